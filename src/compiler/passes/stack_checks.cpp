// SPDX-License-Identifier: Apache-2.0
// See stack_checks.h.
#include "compiler/passes/stack_checks.h"

#include <llvm/ADT/SCCIterator.h>
#include <llvm/Analysis/CallGraph.h>
#include <llvm/IR/DebugInfoMetadata.h>
#include <llvm/IR/InstIterator.h>

namespace sunstone::compiler {

namespace {

using llvm::Value;

constexpr uint64_t kLargeFrame = 4096;

uint64_t localBytes(const llvm::Function& function) {
    const llvm::DataLayout& layout = function.getParent()->getDataLayout();
    uint64_t bytes = 0;
    for (const llvm::Instruction& instruction : llvm::instructions(function))
        if (const auto* local = llvm::dyn_cast<llvm::AllocaInst>(&instruction))
            if (const auto size = local->getAllocationSize(layout))
                bytes += size->getFixedValue();
    return bytes;
}

std::set<llvm::Function*> recursiveFunctions(llvm::Module& module) {
    std::set<llvm::Function*> result;
    llvm::CallGraph graph(module);
    for (auto component = llvm::scc_begin(&graph); !component.isAtEnd(); ++component)
        if (component.hasCycle())
            for (llvm::CallGraphNode* node : *component)
                if (node->getFunction())
                    result.insert(node->getFunction());
    return result;
}

// Gives a check the name and line of the function that it precedes; null if the function has none.
llvm::DILocation* locate(llvm::Function& check, const llvm::Function& function) {
    const llvm::DISubprogram* of = function.getSubprogram();
    if (!of)
        return nullptr;
    auto* own = llvm::DISubprogram::getDistinct(
        check.getContext(), of->getScope(), of->getName(), of->getLinkageName(), of->getFile(),
        of->getLine(), of->getType(), of->getScopeLine(), of->getContainingType(),
        of->getVirtualIndex(), of->getThisAdjustment(), of->getFlags(), of->getSPFlags(),
        of->getUnit());
    check.setSubprogram(own);
    return llvm::DILocation::get(check.getContext(), of->getLine(), 0, own);
}

// Moves the body of `function` after a check for `bytes` of stack below the current frame.
void addCheck(Unit& unit, llvm::Function& function, uint64_t bytes) {
    llvm::LLVMContext& context = unit.context();
    auto* check = llvm::Function::Create(function.getFunctionType(), function.getLinkage(), "",
                                         unit.module());
    check->copyAttributesFrom(&function);
    check->takeName(&function);
    function.setName(check->getName() + kCheckedSuffix);
    function.replaceAllUsesWith(check);
    function.setLinkage(llvm::GlobalValue::InternalLinkage);
    function.addFnAttr(llvm::Attribute::NoInline);
    llvm::DILocation* const place = locate(*check, function);

    auto* entry = llvm::BasicBlock::Create(context, "entry", check);
    auto* fits = llvm::BasicBlock::Create(context, "fits", check);
    auto* overflow = llvm::BasicBlock::Create(context, "overflow", check);
    llvm::IRBuilder<> builder(entry);
    builder.SetCurrentDebugLocation(place);
    llvm::Type* pointer = builder.getPtrTy();
    Value* state = check->getArg(0);
    const auto field = [&](Value* base, size_t offset, llvm::Type* type) {
        return builder.CreateLoad(
            type, builder.CreateInBoundsGEP(builder.getInt8Ty(), base, builder.getInt64(offset)));
    };
    Value* here = builder.CreatePtrToInt(builder.CreateAlloca(builder.getInt8Ty()),
                                         builder.getInt64Ty());
    Value* thread = field(state, offsetof(devlib::RayState, thread), pointer);
    Value* limit = field(thread, offsetof(devlib::ThreadState, stackLimit), builder.getInt64Ty());
    Value* room = builder.CreateSub(here, builder.getInt64(bytes));
    builder.CreateCondBr(builder.CreateICmpULT(room, limit), overflow, fits);

    builder.SetInsertPoint(fits);
    std::vector<Value*> arguments;
    for (llvm::Argument& argument : check->args())
        arguments.push_back(&argument);
    llvm::CallInst* call = builder.CreateCall(&function, arguments);
    const auto finish = [&](Value* value) {
        if (function.getReturnType()->isVoidTy())
            builder.CreateRetVoid();
        else
            builder.CreateRet(value);
    };
    finish(call);

    builder.SetInsertPoint(overflow);
    Value* launch =
        unit.isGpu() ? nullptr : field(state, offsetof(devlib::RayState, launch), pointer);
    auto* type = llvm::FunctionType::get(builder.getVoidTy(),
                                         {pointer, builder.getInt32Ty(), pointer}, false);
    Value* raise =
        unit.launchFunction(builder, launch, offsetof(devlib::LaunchState, raise), "raise", type);
    builder
        .CreateCall(type, raise,
                    {state, builder.getInt32(uint32_t(devlib::kExceptionStackOverflow)),
                     llvm::ConstantPointerNull::get(builder.getPtrTy())})
        ->setTailCallKind(llvm::CallInst::TCK_NoTail); // the return address names the function
    finish(function.getReturnType()->isVoidTy()
               ? nullptr
               : llvm::Constant::getNullValue(function.getReturnType()));
}

// The largest sum of frames along the calls below a function.
class StackWalk {
public:
    explicit StackWalk(const std::map<std::string, uint32_t>& frames) : frames_(frames) {}

    uint32_t need(const llvm::Function& function) {
        if (function.isDeclaration() || !active_.insert(&function).second)
            return 0;
        const auto known = known_.find(&function);
        uint32_t bytes = known == known_.end() ? 0 : known->second;
        if (known == known_.end()) {
            const auto frame = frames_.find(function.getName().str());
            uint32_t deepest = 0;
            for (const llvm::Instruction& instruction : llvm::instructions(function))
                if (const auto* call = llvm::dyn_cast<llvm::CallBase>(&instruction))
                    if (const llvm::Function* callee = call->getCalledFunction())
                        deepest = std::max(deepest, need(*callee));
            constexpr uint32_t kReturnAddress = 8;
            bytes = deepest + kReturnAddress + (frame == frames_.end() ? 0 : frame->second);
            known_[&function] = bytes;
        }
        active_.erase(&function);
        return bytes;
    }

private:
    const std::map<std::string, uint32_t>& frames_;
    std::set<const llvm::Function*> active_;
    std::map<const llvm::Function*, uint32_t> known_;
};

} // namespace

uint32_t stackNeed(Unit& unit, const std::string& function,
                   const std::map<std::string, uint32_t>& frames) {
    const llvm::Function* root = unit.module().getFunction(function);
    return root ? StackWalk(frames).need(*root) : 0;
}

void addStackChecks(Unit& unit) {
    const std::set<llvm::Function*> recursive = recursiveFunctions(unit.module());
    std::vector<std::pair<llvm::Function*, uint64_t>> checked;
    for (llvm::Function& function : unit.module()) {
        // Functions without the hidden parameter do not recurse.
        if (function.isDeclaration() || function.arg_empty() ||
            !function.getArg(0)->getType()->isPointerTy())
            continue;
        const uint64_t bytes = localBytes(function);
        const bool internal = function.hasLocalLinkage();
        if (bytes > kLargeFrame || recursive.count(&function) ||
            (internal && function.hasAddressTaken()))
            checked.emplace_back(&function, bytes);
    }
    for (const auto& [function, bytes] : checked)
        addCheck(unit, *function, bytes);
}

} // namespace sunstone::compiler
