// SPDX-License-Identifier: Apache-2.0
// See gpu/link.h.
#include "compiler/gpu/link.h"

#include "base/error.h"

#include <llvm/Bitcode/BitcodeReader.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/Linker/Linker.h>
#include <llvm/Passes/PassBuilder.h>
#include <llvm/Support/MemoryBuffer.h>
#include <llvm/Transforms/Scalar/SCCP.h>
#include <llvm/Transforms/Scalar/SimplifyCFG.h>

#include <set>

namespace sunstone::compiler {

namespace {

// The section of functions that devlib/gpu/programs.h marks for inlining into their callers.
constexpr const char* kPartSection = ".sunstone.part";

[[noreturn]] void failWith(const char* what, llvm::Error error) {
    fail(Code::kInternal, "the run-time for GPUs cannot be ", what, ": ",
         llvm::toString(std::move(error)));
}

std::unique_ptr<llvm::Module> openBitcode(llvm::LLVMContext& context, std::string_view bitcode) {
    auto buffer = llvm::MemoryBuffer::getMemBuffer(llvm::StringRef(bitcode.data(), bitcode.size()),
                                                   "run-time", false);
    auto module = llvm::getOwningLazyBitcodeModule(std::move(buffer), context);
    if (!module)
        failWith("read", module.takeError());
    return std::move(*module);
}

// Reads functions from the bitcode, starting with the requested ones. In each function it removes
// code that constants exclude, then follows the remaining references.
class Reader {
public:
    explicit Reader(llvm::TargetMachine& machine) : builder_(&machine) {
        builder_.registerModuleAnalyses(modules_);
        builder_.registerCGSCCAnalyses(components_);
        builder_.registerFunctionAnalyses(functions_);
        builder_.registerLoopAnalyses(loops_);
        builder_.crossRegisterProxies(loops_, functions_, components_, modules_);
        simplify_.addPass(llvm::SCCPPass());
        simplify_.addPass(llvm::SimplifyCFGPass());
    }

    void add(llvm::Function& function) {
        if (!function.isDeclaration() && known_.insert(&function).second)
            queue_.push_back(&function);
    }

    void run() {
        while (!queue_.empty()) {
            llvm::Function& function = *queue_.back();
            queue_.pop_back();
            if (llvm::Error error = function.materialize())
                failWith("read", std::move(error));
            simplify_.run(function, functions_);
            for (const llvm::Instruction& instruction : llvm::instructions(function))
                for (const llvm::Use& operand : instruction.operands())
                    if (auto* used = llvm::dyn_cast<llvm::Function>(operand.get()))
                        add(*used);
        }
    }

private:
    llvm::PassBuilder builder_;
    llvm::LoopAnalysisManager loops_;
    llvm::FunctionAnalysisManager functions_;
    llvm::CGSCCAnalysisManager components_;
    llvm::ModuleAnalysisManager modules_;
    llvm::FunctionPassManager simplify_;
    std::set<llvm::Function*> known_;
    std::vector<llvm::Function*> queue_;
};

} // namespace

void linkGpuRuntime(llvm::Module& module, llvm::TargetMachine& machine, std::string_view bitcode,
                    const std::vector<std::pair<std::string, uint32_t>>& constants) {
    std::unique_ptr<llvm::Module> runtime = openBitcode(module.getContext(), bitcode);
    runtime->setTargetTriple(module.getTargetTriple());
    runtime->setDataLayout(module.getDataLayout());
    llvm::Type* const word = llvm::Type::getInt32Ty(module.getContext());
    for (const auto& [name, value] : constants)
        if (llvm::GlobalVariable* variable = runtime->getNamedGlobal(name)) {
            variable->setInitializer(llvm::ConstantInt::get(word, value));
            variable->setLinkage(llvm::GlobalValue::InternalLinkage);
        }
    for (llvm::Function& function : *runtime) { // the build's attributes name an older device
        function.removeFnAttr("target-cpu");
        function.removeFnAttr("target-features");
        if (function.getSection() == kPartSection) {
            function.setSection("");
            function.removeFnAttr(llvm::Attribute::NoInline);
            function.addFnAttr(llvm::Attribute::AlwaysInline);
        }
    }
    Reader reader(machine);
    for (llvm::Function& function : module)
        if (function.isDeclaration())
            if (llvm::Function* found = runtime->getFunction(function.getName()))
                reader.add(*found);
    reader.run();
    if (llvm::Linker::linkModules(module, std::move(runtime), llvm::Linker::LinkOnlyNeeded))
        fail(Code::kInternal, "the run-time for GPUs cannot be linked");
}

} // namespace sunstone::compiler
