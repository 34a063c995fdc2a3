// SPDX-License-Identifier: Apache-2.0
// What all flavors of programs need to lower their intrinsics: loads and stores on the ray state,
// calls of the launch's functions, ends of programs. Offsets come from the structs of devlib/abi.h.
// A flavor derives from ProgramLowering and says what each call becomes.
#pragma once

#include "compiler/translate/call_site.h"
#include "compiler/translate/unit.h"

#include <llvm/IR/InstIterator.h>
#include <llvm/Transforms/Utils/BasicBlockUtils.h>
#include <llvm/Transforms/Utils/Local.h>

#include <set>
#include <string_view>
#include <vector>

namespace sunstone::compiler {

class ProgramLowering {
protected:
    using Hit = devlib::Hit;
    using InstanceRecord = devlib::InstanceRecord;
    using LaunchState = devlib::LaunchState;
    using RayState = devlib::RayState;
    using ThreadState = devlib::ThreadState;
    using Value = llvm::Value;

    // `prefix`: of the intrinsics' names in messages.
    ProgramLowering(Unit& unit, llvm::Function& function, ProgramKind kind, std::string_view prefix)
        : unit_(unit), function_(function), kind_(kind), prefix_(prefix), builder_(unit.context()) {
    }
    virtual ~ProgramLowering() = default;

    // Calls lower() for each intrinsic call of the function, with call_ and intrinsic_ set.
    void lowerAll() {
        std::vector<llvm::CallInst*> calls;
        for (llvm::Instruction& instruction : llvm::instructions(function_))
            if (auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction))
                if (call->getCalledFunction() && unit_.intrinsicOf(call->getCalledFunction()))
                    calls.push_back(call);
        pending_.insert(calls.begin(), calls.end());
        for (llvm::CallInst* call : calls) {
            if (!pending_.erase(call))
                continue;
            call_ = call;
            intrinsic_ = unit_.intrinsicOf(call->getCalledFunction());
            builder_.SetInsertPoint(call);
            lower();
        }
    }
    virtual void lower() = 0;

    [[noreturn]] void fault(ErrorCode code, const std::string& text) const {
        ptx::Location location;
        location.line = callSite(unit_, *call_).line;
        failAt(code, location, prefix_, intrinsic_->name, ": ", text);
    }

    llvm::Type* word() { return builder_.getInt32Ty(); }
    llvm::Type* pointer() { return builder_.getPtrTy(); }
    Value* state() { return function_.getArg(0); }
    Value* argument(unsigned index) { return call_->getArgOperand(index + 1); }

    Value* address(Value* base, size_t offset) {
        return offset == 0 ? base
                           : builder_.CreateInBoundsGEP(builder_.getInt8Ty(), base,
                                                        builder_.getInt64(offset));
    }
    Value* load(Value* base, size_t offset, llvm::Type* type) {
        return builder_.CreateAlignedLoad(
            type, address(base, offset),
            llvm::Align(type->isPointerTy() || type->isIntegerTy(64) ? 8 : 4));
    }
    // Of what does not change while a program runs.
    Value* loadInvariant(Value* base, size_t offset, llvm::Type* type) {
        auto* value = llvm::cast<llvm::LoadInst>(load(base, offset, type));
        llvm::MDNode* mark = llvm::MDNode::get(unit_.context(), {});
        if (unit_.isGpu())
            value->setMetadata(kStableLoad, mark);
        else
            value->setMetadata(llvm::LLVMContext::MD_invariant_load, mark);
        return value;
    }
    // Of what does not change while the launch runs.
    Value* loadOfLaunch(Value* base, size_t offset, llvm::Type* type) {
        Value* value = load(base, offset, type);
        llvm::cast<llvm::LoadInst>(value)->setMetadata(llvm::LLVMContext::MD_invariant_load,
                                                       llvm::MDNode::get(unit_.context(), {}));
        return value;
    }
    void store(Value* base, size_t offset, Value* value) {
        builder_.CreateAlignedStore(
            value, address(base, offset),
            llvm::Align(value->getType()->isPointerTy() || value->getType()->isIntegerTy(64) ? 8
                                                                                             : 4));
    }
    Value* launch() { return loadOfLaunch(state(), offsetof(RayState, launch), pointer()); }
    Value* launchFunction(size_t offset, const char* name, llvm::FunctionType* type) {
        return unit_.launchFunction(builder_, unit_.isGpu() ? nullptr : launch(), offset, name,
                                    type);
    }
    Value* thread() { return loadOfLaunch(state(), offsetof(RayState, thread), pointer()); }

    void replace(Value* value) {
        call_->replaceAllUsesWith(value);
        call_->eraseFromParent();
    }

    // Replaces the call and all that follows in its block by a return.
    void endProgram(uint32_t result) {
        if (kind_ == ProgramKind::kNone || !function_.getReturnType()->isIntegerTy(32))
            fault(ErrorCode::kInvalidFunctionUse,
                  "cannot end a program from a function that is called "
                  "through its address");
        finishBlock(builder_.getInt32(result));
    }

    void finishBlock(Value* result) {
        llvm::BasicBlock* block = call_->getParent();
        for (llvm::Instruction& dead : llvm::make_range(call_->getIterator(), block->end()))
            if (auto* call = llvm::dyn_cast<llvm::CallInst>(&dead))
                pending_.erase(call);
        llvm::changeToUnreachable(call_);
        llvm::Instruction* end = block->getTerminator();
        builder_.SetInsertPoint(end);
        if (function_.getReturnType()->isVoidTy())
            builder_.CreateRetVoid();
        else
            builder_.CreateRet(result);
        end->eraseFromParent();
    }

    Value* entryAlloca(llvm::Type* type, unsigned alignment) {
        llvm::IRBuilder<>::InsertPointGuard guard(builder_);
        builder_.SetInsertPoint(&function_.getEntryBlock(), function_.getEntryBlock().begin());
        auto* memory = builder_.CreateAlloca(type);
        memory->setAlignment(llvm::Align(alignment));
        return memory;
    }

    // All trace calls of a function share one state: none is live across another.
    Value* rayMemory() {
        if (!rayMemory_)
            rayMemory_ = entryAlloca(llvm::ArrayType::get(builder_.getInt8Ty(), sizeof(RayState)),
                                     alignof(RayState));
        return rayMemory_;
    }

    // Reports a hit to the run-time; the value says whether it was accepted. The program ends where
    // the ray does.
    Value* callReport(Value* t, Value* kind) {
        auto* type =
            llvm::FunctionType::get(word(), {pointer(), builder_.getFloatTy(), word()}, false);
        Value* target = launchFunction(offsetof(LaunchState, report), "report", type);
        Value* result = builder_.CreateCall(type, target, {state(), t, kind});
        Value* accepted = builder_.CreateZExt(
            builder_.CreateICmpEQ(result, builder_.getInt32(devlib::kAccept)), word());
        Value* ended = builder_.CreateICmpEQ(result, builder_.getInt32(devlib::kTerminate));
        if (kind_ == ProgramKind::kNone)
            fault(ErrorCode::kInvalidFunctionUse, "cannot report from a function that is called "
                                                  "through its address");
        llvm::Instruction* end = llvm::SplitBlockAndInsertIfThen(ended, call_, true);
        builder_.SetInsertPoint(end);
        builder_.CreateRet(builder_.getInt32(devlib::kTerminate));
        end->eraseFromParent();
        return accepted;
    }

    Unit& unit_;
    llvm::Function& function_;
    const ProgramKind kind_;
    const std::string_view prefix_;
    llvm::IRBuilder<> builder_;
    llvm::CallInst* call_ = nullptr;
    const Intrinsic* intrinsic_ = nullptr;

private:
    std::set<llvm::CallInst*> pending_; // not lowered and not deleted yet
    Value* rayMemory_ = nullptr;
};

} // namespace sunstone::compiler
