// SPDX-License-Identifier: Apache-2.0
// See resumable.h.
#include "compiler/gpu/resumable.h"

#include "base/error.h"
#include "compiler/passes/optimizer.h"
#include "compiler/translate/unit.h"

#include <llvm/ADT/SmallPtrSet.h>
#include <llvm/IR/CFG.h>
#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/InlineAsm.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/IntrinsicsNVPTX.h>
#include <llvm/Passes/PassBuilder.h>
#include <llvm/Transforms/Coroutines/CoroCleanup.h>
#include <llvm/Transforms/Coroutines/CoroEarly.h>
#include <llvm/Transforms/Coroutines/CoroSplit.h>
#include <llvm/Transforms/InstCombine/InstCombine.h>
#include <llvm/Transforms/Scalar/ADCE.h>
#include <llvm/Transforms/Scalar/EarlyCSE.h>
#include <llvm/Transforms/Scalar/SROA.h>
#include <llvm/Transforms/Scalar/SimplifyCFG.h>

#include <set>

namespace sunstone::compiler {

namespace {

using llvm::Value;

constexpr const char *kTrace = "sunstone_gpu_trace", *kTraceInline = "sunstone_gpu_traceInline";
constexpr const char* kFrameBytes = "sunstone.frame.bytes"; // its calls return a frame's size
// Calls of these functions stand for the parameters of the functions that a program is cut into.
constexpr const char *kRoot = "sunstone.lane.root", *kRay = "sunstone.lane.ray",
                     *kAsks = "sunstone.lane.asks";
// The parameters after the frame, in order.
constexpr const char* kParameters[] = {kRoot, kRay, kAsks};

std::vector<llvm::CallInst*> tracesOf(const llvm::Function& program) {
    std::vector<llvm::CallInst*> calls;
    const llvm::Function* trace = program.getParent()->getFunction(kTrace);
    if (trace)
        for (const llvm::User* user : trace->users()) {
            auto* call = llvm::dyn_cast<llvm::CallInst>(user);
            if (call && call->getCalledOperand() == trace && call->getFunction() == &program)
                calls.push_back(const_cast<llvm::CallInst*>(call));
        }
    return calls;
}

// Instructions of PTX at which lanes wait for one another.
bool meets(const llvm::CallInst& call) {
    if (const auto* code = llvm::dyn_cast<llvm::InlineAsm>(call.getCalledOperand())) {
        const llvm::StringRef text = code->getAsmString();
        for (const char* word : {"bar.", "barrier", ".sync", "griddepcontrol"})
            if (text.contains(word))
                return true;
        return false;
    }
    const llvm::Function* callee = call.getCalledFunction();
    if (!callee || !callee->isIntrinsic())
        return false;
    const llvm::StringRef name = callee->getName();
    return name.starts_with("llvm.nvvm.") &&
           (name.contains(".sync") || name.contains(".bar.") || name.contains(".barrier"));
}

// A program during its conversion to a coroutine, void(frame).
class Coroutine {
public:
    explicit Coroutine(llvm::Function& program)
        : program_(program), module_(*program.getParent()), builder_(program.getContext()) {}

    llvm::Function* make() {
        auto* type = llvm::FunctionType::get(builder_.getVoidTy(), {builder_.getPtrTy()}, false);
        function_ = llvm::Function::Create(
            type, llvm::GlobalValue::ExternalLinkage, // or the passes do not see it
            program_.getName() + "$start", module_);
        function_->copyAttributesFrom(&program_);
        function_->setAttributes({});
        function_->addFnAttr(llvm::Attribute::NoUnwind);
        function_->setPresplitCoroutine();
        function_->splice(function_->begin(), &program_);
        begin();
        shareRay();
        for (llvm::CallInst* call : tracesOf(*function_))
            suspend(*call);
        end();
        return function_;
    }

private:
    Value* parameter(const char* name) {
        auto* type = llvm::FunctionType::get(builder_.getPtrTy(), false);
        auto* function =
            llvm::cast<llvm::Function>(module_.getOrInsertFunction(name, type).getCallee());
        function->setDoesNotAccessMemory();
        function->setDoesNotThrow();
        function->setWillReturn();
        return builder_.CreateCall(type, function);
    }

    void begin() {
        llvm::BasicBlock* first = &function_->getEntryBlock();
        auto* entry = llvm::BasicBlock::Create(program_.getContext(), "begin", function_, first);
        for (llvm::Instruction& each : llvm::make_early_inc_range(*first))
            if (llvm::isa<llvm::AllocaInst>(each)) // allocas must be in the entry block
                each.moveBefore(*entry, entry->end());
        builder_.SetInsertPoint(entry);
        Value* none = llvm::ConstantPointerNull::get(builder_.getPtrTy());
        Value* id = builder_.CreateIntrinsic(
            llvm::Intrinsic::coro_id, {}, {builder_.getInt32(kFrameAlignment), none, none, none});
        Value* size =
            builder_.CreateIntrinsic(llvm::Intrinsic::coro_size, {builder_.getInt64Ty()}, {});
        builder_.CreateCall(
            module_.getOrInsertFunction(kFrameBytes, builder_.getVoidTy(), builder_.getInt64Ty()),
            {size});
        frame_ =
            builder_.CreateIntrinsic(llvm::Intrinsic::coro_begin, {}, {id, function_->getArg(0)});
        root_ = parameter(kRoot);
        program_.getArg(0)->replaceAllUsesWith(root_);
        ray_ = parameter(kRay);
        asks_ = parameter(kAsks);
        builder_.CreateBr(first);
        done_ = llvm::BasicBlock::Create(program_.getContext(), "done", function_);
    }

    // Merges the states of the program's rays into one, because no state is live across another
    // ray's trace.
    void shareRay() {
        for (llvm::CallInst* call : tracesOf(*function_)) {
            auto* memory = llvm::dyn_cast<llvm::AllocaInst>(call->getArgOperand(0));
            if (!memory) // merged with an earlier trace
                continue;
            for (llvm::User* user : llvm::make_early_inc_range(memory->users()))
                if (auto* marker = llvm::dyn_cast<llvm::LifetimeIntrinsic>(user))
                    marker->eraseFromParent();
            memory->replaceAllUsesWith(ray_);
            memory->eraseFromParent();
        }
    }

    void suspend(llvm::CallInst& call) {
        llvm::BasicBlock* before = call.getParent();
        llvm::BasicBlock* after = before->splitBasicBlock(&call, "resumed");
        before->getTerminator()->eraseFromParent();
        call.eraseFromParent();
        builder_.SetInsertPoint(before);
        builder_.CreateStore(builder_.getInt32(1), asks_);
        Value* how = builder_.CreateIntrinsic(
            llvm::Intrinsic::coro_suspend, {},
            {llvm::ConstantTokenNone::get(program_.getContext()), builder_.getFalse()});
        builder_.CreateSwitch(how, done_, 1)->addCase(builder_.getInt8(0), after);
    }

    void end() {
        for (llvm::BasicBlock& block : *function_)
            if (auto* leaves = llvm::dyn_cast_or_null<llvm::ReturnInst>(block.getTerminator())) {
                builder_.SetInsertPoint(leaves);
                builder_.CreateBr(done_);
                leaves->eraseFromParent();
            }
        builder_.SetInsertPoint(done_);
        builder_.CreateIntrinsic(
            llvm::Intrinsic::coro_end, {},
            {frame_, builder_.getFalse(), llvm::ConstantTokenNone::get(program_.getContext())});
        builder_.CreateRetVoid();
    }

    llvm::Function& program_;
    llvm::Module& module_;
    llvm::IRBuilder<> builder_;
    llvm::Function* function_ = nullptr;
    llvm::BasicBlock* done_ = nullptr;
    Value *frame_ = nullptr, *root_ = nullptr, *ray_ = nullptr, *asks_ = nullptr;
};

// Which of kParameters an instruction stands for, or -1.
int parameterOf(const llvm::Instruction& instruction) {
    const auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction);
    const llvm::Function* callee = call ? call->getCalledFunction() : nullptr;
    for (int i = 0; callee && i < int(std::size(kParameters)); ++i)
        if (callee->getName() == kParameters[i])
            return i;
    return -1;
}

bool isStable(const llvm::Instruction& instruction) {
    return parameterOf(instruction) >= 0 ||
           (llvm::isa<llvm::LoadInst>(instruction) &&
            (instruction.hasMetadata(llvm::LLVMContext::MD_invariant_load) ||
             instruction.hasMetadata(kStableLoad)));
}

bool isArithmetic(const llvm::Instruction& instruction) {
    return llvm::isa<llvm::CastInst, llvm::GetElementPtrInst, llvm::BinaryOperator, llvm::CmpInst,
                     llvm::SelectInst>(instruction);
}

// Adds the values that the frame must keep so that the expression can be repeated. False: more than
// kMostKept values.
constexpr size_t kMostKept = 4;
bool addNeeds(const llvm::Instruction& instruction, unsigned depth,
              llvm::SmallPtrSetImpl<const llvm::Instruction*>& needs) {
    constexpr unsigned kMostDepth = 8;
    for (const Value* operand : instruction.operands()) {
        const auto* from = llvm::dyn_cast<llvm::Instruction>(operand);
        if (!from || isStable(*from))
            continue;
        llvm::SmallPtrSet<const llvm::Instruction*, kMostKept + 1> own;
        if (!isArithmetic(*from) || depth == kMostDepth || !addNeeds(*from, depth + 1, own))
            own = {from};
        needs.insert(own.begin(), own.end());
    }
    return needs.size() <= kMostKept;
}

// Whether the instruction is repeated after a trace, in place of keeping its value in the frame: a
// load of a value that stays the same for a launch index, or arithmetic on a few values. Repeating
// arithmetic on many values would keep them all: for a transformed normal, the whole matrix.
bool isCheap(llvm::Instruction& instruction) {
    llvm::SmallPtrSet<const llvm::Instruction*, kMostKept + 1> needs;
    return isStable(instruction) || (isArithmetic(instruction) && addNeeds(instruction, 0, needs));
}

void split(llvm::Module& module, llvm::TargetMachine& machine) {
    llvm::PassBuilder builder(&machine);
    llvm::LoopAnalysisManager loops;
    llvm::FunctionAnalysisManager functions;
    llvm::CGSCCAnalysisManager components;
    llvm::ModuleAnalysisManager modules;
    builder.registerModuleAnalyses(modules);
    builder.registerCGSCCAnalyses(components);
    builder.registerFunctionAnalyses(functions);
    builder.registerLoopAnalyses(loops);
    builder.crossRegisterProxies(loops, functions, components, modules);
    llvm::FunctionPassManager simplify; // reduces the values that live across a trace
    simplify.addPass(llvm::SROAPass(llvm::SROAOptions::ModifyCFG));
    simplify.addPass(llvm::EarlyCSEPass(true));
    simplify.addPass(llvm::InstCombinePass());
    simplify.addPass(llvm::SimplifyCFGPass());
    simplify.addPass(llvm::ADCEPass());
    llvm::ModulePassManager passes;
    passes.addPass(llvm::CoroEarlyPass());
    passes.addPass(llvm::createModuleToFunctionPassAdaptor(std::move(simplify)));
    passes.addPass(llvm::createModuleToPostOrderCGSCCPassAdaptor(
        llvm::CoroSplitPass(isCheap, /*OptimizeFrame=*/true)));
    passes.addPass(llvm::CoroCleanupPass());
    keepNullAccesses(module);
    passes.run(module, modules);
}

// LLVM stores the addresses of the functions that resume and destroy the coroutine in its frame.
// The loop calls the first by name and never calls the second, so the stores are removed.
void dropAddresses(llvm::Function& function) {
    for (llvm::User* user : llvm::make_early_inc_range(function.users()))
        if (auto* store = llvm::dyn_cast<llvm::StoreInst>(user))
            store->eraseFromParent();
}

// Gives a part of a program, void(frame), the parameters that Cut describes.
llvm::Function* withStates(llvm::Function* part) {
    llvm::Module& module = *part->getParent();
    llvm::Type* pointer = llvm::PointerType::get(module.getContext(), 0);
    auto* function = llvm::Function::Create(
        llvm::FunctionType::get(llvm::Type::getVoidTy(module.getContext()),
                                {pointer, pointer, pointer, pointer}, false),
        llvm::GlobalValue::InternalLinkage, part->getName() + ".part", module);
    function->addFnAttr(llvm::Attribute::NoUnwind);
    function->splice(function->begin(), part);
    part->getArg(0)->replaceAllUsesWith(function->getArg(0));
    for (llvm::Instruction& each : llvm::make_early_inc_range(llvm::instructions(*function)))
        if (const int place = parameterOf(each); place >= 0) {
            each.replaceAllUsesWith(function->getArg(unsigned(place) + 1));
            each.eraseFromParent();
        }
    return function;
}

uint64_t largestFrame(llvm::Module& module) {
    uint64_t largest = 0;
    llvm::Function* marker = module.getFunction(kFrameBytes);
    for (llvm::User* user : llvm::make_early_inc_range(marker->users())) {
        auto* call = llvm::cast<llvm::CallInst>(user);
        const auto* size = llvm::dyn_cast<llvm::ConstantInt>(call->getArgOperand(0));
        if (!size)
            fail(ErrorCode::kInternal, "a program was not cut at its traces");
        largest = std::max(largest, size->getZExtValue());
        call->eraseFromParent();
    }
    marker->eraseFromParent();
    return largest;
}

} // namespace

std::vector<llvm::Function*> tracingFunctions(llvm::Module& module) {
    std::vector<llvm::Function*> result;
    for (llvm::Function& function : module)
        if (!tracesOf(function).empty())
            result.push_back(&function);
    return result;
}

bool tracesInLoop(const llvm::Function& program) {
    const std::vector<llvm::CallInst*> calls = tracesOf(program);
    if (calls.size() != 1)
        return false;
    const llvm::BasicBlock* const block = calls[0]->getParent();
    std::set<const llvm::BasicBlock*> seen;
    std::vector<const llvm::BasicBlock*> queue(llvm::succ_begin(block), llvm::succ_end(block));
    while (!queue.empty()) {
        const llvm::BasicBlock* each = queue.back();
        queue.pop_back();
        if (each == block)
            return true;
        if (seen.insert(each).second)
            queue.insert(queue.end(), llvm::succ_begin(each), llvm::succ_end(each));
    }
    return false;
}

bool tracesOnce(const llvm::Function& program) {
    return tracesOf(program).size() == 1 && !tracesInLoop(program);
}

std::string obstacleToCut(const llvm::Function& program) {
    if (!program.use_empty())
        return "a program that traces is called by another function";
    for (const llvm::CallInst* call : tracesOf(program))
        if (!llvm::isa<llvm::AllocaInst>(call->getArgOperand(0)))
            return "a ray's state is not the program's own";
    for (const llvm::Function& function : *program.getParent())
        for (const llvm::Instruction& instruction : llvm::instructions(function))
            if (const auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction))
                if (meets(*call))
                    return "a program has instructions at which the lanes of a warp meet";
    return {};
}

void traceInline(const std::vector<llvm::Function*>& programs, size_t most) {
    // Each trace gets a copy of the traversal, which the driver compiles slowly. With more than two
    // traces in a program, inlining makes compilation take half as long again and a path tracer's
    // frames a tenth faster.
    constexpr size_t kMostOfProgram = 2;
    std::vector<llvm::CallInst*> calls;
    for (const llvm::Function* program : programs) {
        const std::vector<llvm::CallInst*> own = tracesOf(*program);
        if (own.size() <= kMostOfProgram)
            calls.insert(calls.end(), own.begin(), own.end());
    }
    if (calls.size() > most)
        return;
    for (llvm::CallInst* call : calls)
        call->setCalledFunction(
            call->getModule()->getOrInsertFunction(kTraceInline, call->getFunctionType()));
}

CutPrograms cutAtTraces(llvm::Module& module, llvm::TargetMachine& machine,
                        const std::vector<llvm::Function*>& programs) {
    CutPrograms result;
    for (llvm::Function* program : programs)
        result.cuts[program].start = Coroutine(*program).make();
    split(module, machine);
    result.frameBytes = largestFrame(module);
    for (auto& [program, cut] : result.cuts) {
        const std::string name = cut.start->getName().str();
        llvm::Function* parts[3];
        for (unsigned i = 0; i < 3; ++i) {
            parts[i] = module.getFunction(name + (i == 0   ? ".resume"
                                                  : i == 1 ? ".destroy"
                                                           : ".cleanup"));
            if (!parts[i])
                fail(ErrorCode::kInternal, "a program was not cut at its traces");
            dropAddresses(*parts[i]);
        }
        llvm::Function* start = cut.start;
        cut.start = withStates(start);
        cut.resume = withStates(parts[0]);
        if (auto* table = module.getNamedGlobal(name + ".resumers"))
            table->eraseFromParent();
        for (llvm::Function* unused : {start, parts[0], parts[1], parts[2]})
            unused->eraseFromParent();
    }
    for (const char* name : kParameters)
        module.getFunction(name)->eraseFromParent();
    return result;
}

} // namespace sunstone::compiler
