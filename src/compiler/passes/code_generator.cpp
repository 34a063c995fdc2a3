// SPDX-License-Identifier: Apache-2.0
// See code_generator.h.
#include "compiler/passes/code_generator.h"

#include "base/error.h"
#include "compiler/passes/passes.h"

#include <llvm/Analysis/CFG.h>
#include <llvm/CodeGen/MachineModuleInfo.h>
#include <llvm/CodeGen/Passes.h>
#include <llvm/CodeGen/StackProtector.h>
#include <llvm/CodeGen/TargetPassConfig.h>
#include <llvm/IR/Function.h>
#include <llvm/IR/Instructions.h>
#include <llvm/IR/Module.h>
#include <llvm/Support/CommandLine.h>

#include <memory>
#include <mutex>
#include <vector>

namespace sunstone::compiler {

namespace {

// Instructions of a block. A split costs a little code at its place, so ordinary blocks stay whole.
constexpr unsigned kLongBlock = 1024, kPart = 512;
// Instructions of a function.
constexpr unsigned kLongFunction = 20000;

class SplitBlocks : public llvm::FunctionPass {
public:
    static char ID;
    SplitBlocks() : llvm::FunctionPass(ID) {}
    llvm::StringRef getPassName() const override { return "Split long blocks"; }
    void getAnalysisUsage(llvm::AnalysisUsage& usage) const override {
        usage.addPreserved<llvm::StackProtector>(); // the selection of instructions asks for it
    }
    bool runOnFunction(llvm::Function& function) override {
        std::vector<llvm::BasicBlock*> blocks;
        for (llvm::BasicBlock& block : function)
            if (block.sizeWithoutDebug() > kLongBlock)
                blocks.push_back(&block);
        for (llvm::BasicBlock* block : blocks)
            split(*block);
        return !blocks.empty();
    }

private:
    // Splits from the end, so that each instruction changes its block only once.
    static void split(llvm::BasicBlock& block) {
        const llvm::Instruction* const first = &*block.getFirstInsertionPt();
        std::vector<llvm::Instruction*> places;
        unsigned count = 0;
        for (llvm::Instruction& instruction : block) {
            if (!llvm::isa<llvm::PHINode>(instruction) &&
                !llvm::isa<llvm::AllocaInst>(instruction) && &instruction != first &&
                !instruction.isTerminator() && ++count % kPart == 0)
                places.push_back(&instruction);
        }
        for (auto place = places.rbegin(); place != places.rend(); ++place)
            block.splitBasicBlock(*place);
    }
};
char SplitBlocks::ID = 0;

// Sets an option of LLVM's command line, the only way to set limits of its passes.
template <class T>
void setOption(const char* name, T value) {
    auto& options = llvm::cl::getRegisteredOptions();
    const auto found = options.find(name);
    if (found == options.end())
        fail(Code::kInternal, "the code generator has no setting ", name);
    static_cast<llvm::cl::opt<T>*>(found->second)->setValue(value);
}

bool hasLongFunction(const llvm::Module& module) {
    return llvm::any_of(module, [](const llvm::Function& function) {
        return function.getInstructionCount() > kLongFunction;
    });
}

bool hasManyLoops(const llvm::Module& module) {
    return llvm::any_of(module, [](const llvm::Function& function) {
        llvm::SmallVector<std::pair<const llvm::BasicBlock*, const llvm::BasicBlock*>> edges;
        if (!function.isDeclaration())
            llvm::FindFunctionBackedges(function, edges);
        return edges.size() > kManyLoops;
    });
}

} // namespace

void limitCodeGenerator() {
    // Accesses that the schedulers compare with each other.
    setOption<unsigned>("dag-maps-huge-region", 64);
    // The pass moves integer code to mask registers. It takes 1.7 % of the time to compile a
    // program, and programs have little of such code.
    setOption<bool>("disable-x86-domain-reassignment", true);
}

bool addCodeGenerator(llvm::TargetMachine& machine, const llvm::Module& module,
                      llvm::legacy::PassManager& passes, llvm::raw_pwrite_stream& stream) {
    auto& target = static_cast<llvm::LLVMTargetMachine&>(machine);
    // The choice of passes reads settings of the process.
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    setOption<bool>("disable-lsr", hasManyLoops(module));
    auto* const info = new llvm::MachineModuleInfoWrapperPass(&target);
    llvm::TargetPassConfig* const config = target.createPassConfig(passes);
    config->setDisableVerify(true);
    // The last pass before instructions are selected.
    const std::unique_ptr<llvm::Pass> last(llvm::createStackProtectorPass());
    config->insertPass(last->getPassID(), new SplitBlocks);
    // The pass takes 6 % of the time to compile a program. Frames of the path tracer are no faster
    // with it, as processors reorder instructions themselves.
    config->disablePass(&llvm::PostRASchedulerID);
    if (hasLongFunction(module)) // it walks over all uses of a constant for each of its places
        config->disablePass(&llvm::MachineCSEID);
    passes.add(config);
    passes.add(info);
    if (config->addISelPasses())
        return false;
    config->addMachinePasses();
    config->setInitialized();
    if (target.addAsmPrinter(passes, stream, nullptr, llvm::CodeGenFileType::ObjectFile,
                             info->getMMI().getContext()))
        return false;
    passes.add(llvm::createFreeMachineFunctionPass());
    return true;
}

} // namespace sunstone::compiler
