// SPDX-License-Identifier: Apache-2.0
// See tracing_callables.h.
#include "compiler/gpu/tracing_callables.h"

#include "base/error.h"
#include "compiler/gpu/resumable.h"

#include <llvm/Analysis/ValueTracking.h>
#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/Support/KnownBits.h>
#include <llvm/Transforms/Utils/BasicBlockUtils.h>
#include <llvm/Transforms/Utils/Cloning.h>

namespace sunstone::compiler {

namespace {

// In LLVM instructions that inlining adds to all programs together (docs/notes/programs-gpu.md).
constexpr size_t kMostInstructions = 8000;

using Functions = std::vector<llvm::Function*>;

ProgramKind kindOf(Unit& unit, llvm::Function* function) {
    const auto known = unit.kinds().find(function);
    return known == unit.kinds().end() ? ProgramKind::kNone : known->second;
}

bool isCallable(ProgramKind kind) {
    return kind == ProgramKind::kDirectCallable || kind == ProgramKind::kContinuationCallable;
}
bool mayBeCut(ProgramKind kind) {
    return kind == ProgramKind::kRaygen || kind == ProgramKind::kClosestHit ||
           kind == ProgramKind::kMiss;
}

std::vector<llvm::CallInst*> callsByAddress(llvm::Function& function) {
    std::vector<llvm::CallInst*> calls;
    for (llvm::Instruction& instruction : llvm::instructions(function))
        if (auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction);
            call && call->isIndirectCall())
            calls.push_back(call);
    return calls;
}

// The call that looks up the callee of a call by address, or null (resolveCallee in
// translate/control.cpp).
const llvm::CallInst* lookUpOf(const llvm::CallInst& call) {
    std::vector<const llvm::Value*> values = {call.getCalledOperand()};
    for (size_t i = 0; i < values.size(); ++i) {
        const llvm::Value* const value = values[i];
        if (const auto* lookUp = llvm::dyn_cast<llvm::CallInst>(value);
            lookUp && lookUp->getCalledFunction() &&
            lookUp->getCalledFunction()->getName() == "sunstone_gpu_callable")
            return lookUp;
        if (const auto* user = llvm::dyn_cast<llvm::User>(value);
            llvm::isa<llvm::PHINode, llvm::SelectInst>(value))
            for (const llvm::Value* operand : user->operands())
                if (!llvm::is_contained(values, operand))
                    values.push_back(operand);
    }
    return nullptr;
}

// Whether the call is known to be of a direct callable.
bool callsDirectly(const llvm::CallInst& call) {
    const llvm::CallInst* const lookUp = lookUpOf(call);
    return lookUp && llvm::computeKnownBits(lookUp->getArgOperand(2),
                                            call.getFunction()->getParent()->getDataLayout())
                         .Zero[0];
}

class Inliner {
public:
    explicit Inliner(Unit& unit) : unit_(unit) {}

    std::string run() {
        if (!findCallables() || !findCalls() || size() > kMostInstructions)
            return {};
        for (llvm::CallInst* call : calls_)
            expand(*call);
        for (llvm::CallInst* call : direct_) {
            llvm::InlineFunctionInfo info;
            llvm::InlineFunction(*call, info);
        }
        for (llvm::Function* callable : callables_)
            empty(*callable);
        return message("callables that trace are part of their callers, at ", calls_.size(),
                       " calls\n");
    }

private:
    // False: there are none, or they keep their place.
    bool findCallables() {
        for (llvm::Function* function : tracingFunctions(unit_.module()))
            if (isCallable(kindOf(unit_, function)))
                callables_.push_back(function);
            else if (!mayBeCut(kindOf(unit_, function)))
                return false;
        return !callables_.empty() && llvm::all_of(callables_, [](llvm::Function* callable) {
            return callable->use_empty() && callsByAddress(*callable).empty();
        });
    }

    // False: a function that is not cut may call them, or a call with other types.
    bool findCalls() {
        for (llvm::Function& function : unit_.module())
            for (llvm::CallInst* call : callsByAddress(function)) {
                if (isOfOtherTypes(*call))
                    return false;
                if (calleesOf(*call).empty())
                    continue;
                if (!mayBeCut(kindOf(unit_, &function)))
                    return false;
                calls_.push_back(call);
            }
        return true;
    }

    bool mayCall(const llvm::CallInst& call, llvm::Function* callable) const {
        return kindOf(unit_, callable) == ProgramKind::kDirectCallable || !callsDirectly(call);
    }

    // Whether no callable has the call's types, so that its callee has others.
    bool isOfOtherTypes(const llvm::CallInst& call) const {
        return llvm::none_of(unit_.kinds(), [&](const auto& known) {
            const auto& [function, kind] = known;
            return isCallable(kind) && function->getFunctionType() == call.getFunctionType();
        });
    }

    Functions calleesOf(const llvm::CallInst& call) const {
        Functions callees;
        for (llvm::Function* callable : callables_)
            if (callable->getFunctionType() == call.getFunctionType() && mayCall(call, callable))
                callees.push_back(callable);
        return callees;
    }

    size_t size() const {
        size_t sum = 0;
        for (const llvm::CallInst* call : calls_)
            for (const llvm::Function* callable : calleesOf(*call))
                sum += callable->getInstructionCount();
        return sum;
    }

    void expand(llvm::CallInst& call) {
        llvm::IRBuilder<> builder(&call);
        llvm::BasicBlock *before = call.getParent(), *join = before->splitBasicBlock(&call),
                         *other = llvm::BasicBlock::Create(unit_.context(), "", before->getParent(),
                                                           join);
        before->getTerminator()->eraseFromParent();
        builder.SetInsertPoint(join, join->begin());
        llvm::PHINode* result =
            call.getType()->isVoidTy() ? nullptr : builder.CreatePHI(call.getType(), 0);
        const auto leaveFrom = [&](llvm::CallInst* done) {
            builder.CreateBr(join);
            if (result)
                result->addIncoming(done, done->getParent());
        };
        builder.SetInsertPoint(before);
        const llvm::SmallVector<llvm::Value*> arguments(call.args());
        for (llvm::Function* callee : calleesOf(call)) {
            auto* own = llvm::BasicBlock::Create(unit_.context(), "", before->getParent(), other);
            auto* next = llvm::BasicBlock::Create(unit_.context(), "", before->getParent(), other);
            builder.CreateCondBr(builder.CreateICmpEQ(call.getCalledOperand(), callee), own, next);
            builder.SetInsertPoint(own);
            direct_.push_back(builder.CreateCall(callee, arguments));
            leaveFrom(direct_.back());
            builder.SetInsertPoint(next);
        }
        builder.CreateBr(other);
        if (result)
            call.replaceAllUsesWith(result);
        call.moveBefore(*other, other->end());
        builder.SetInsertPoint(other);
        leaveFrom(&call);
    }

    // Its address remains, for the comparisons and the dispatchers.
    static void empty(llvm::Function& function) {
        const auto linkage = function.getLinkage();
        function.deleteBody();
        function.setLinkage(linkage);
        llvm::IRBuilder<> builder(llvm::BasicBlock::Create(function.getContext(), "", &function));
        if (llvm::Type* type = function.getReturnType(); type->isVoidTy())
            builder.CreateRetVoid();
        else
            builder.CreateRet(llvm::Constant::getNullValue(type));
    }

    Unit& unit_;
    Functions callables_;
    std::vector<llvm::CallInst*> calls_, direct_;
};

} // namespace

std::string inlineTracingCallables(Unit& unit) {
    return Inliner(unit).run();
}

} // namespace sunstone::compiler
