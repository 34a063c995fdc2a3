// SPDX-License-Identifier: Apache-2.0
// LockstepEmitter: warp functions whose lanes are all active. Results are those of
// runtime/kernel.cpp for threads that run one by one.
#include "compiler/lockstep/emit.h"
#include "compiler/lockstep/warp_functions.h"

namespace sunstone::compiler {

using devlib::LockstepWarp;
using llvm::cast;
using llvm::dyn_cast;
using llvm::Value;

// Whether every lane names the same partners, including itself, and all partners that have not
// ended are active. The emitted code tracks lanes that have ended.
Value* LockstepEmitter::canAnswer(const MeetingPoint& point, Value* bits) {
    Value* operand = point.call->getArgOperand(point.kind == devlib::kMeetShuffle ? 5 : 2);
    Value* same = builder_.getTrue();
    Value* partners = nullptr;
    if (isUniform(operand)) {
        partners = scalar(operand);
    } else {
        Value* all = wide(operand);
        partners = builder_.CreateExtractElement(all, firstLane(bits));
        Value* equal = select(mask_, builder_.CreateICmpEQ(all, splat(partners)),
                              llvm::Constant::getAllOnesValue(mask_->getType()));
        same = builder_.CreateICmpEQ(maskBits(equal), builder_.getInt32(~0u));
    }
    Value* live = builder_.CreateLoad(builder_.getInt32Ty(), field(offsetof(LockstepWarp, live)));
    Value* ended = builder_.CreateAnd(
        builder_.CreateAnd(partners, builder_.CreateLoad(builder_.getInt32Ty(),
                                                         field(offsetof(LockstepWarp, all)))),
        builder_.CreateNot(live));
    Value* named = field(offsetof(LockstepWarp, namedEnded));
    builder_.CreateStore(
        builder_.CreateOr(builder_.CreateLoad(builder_.getInt32Ty(), named), ended), named);
    Value* missing =
        builder_.CreateAnd(builder_.CreateAnd(partners, live), builder_.CreateNot(bits));
    Value* strangers = builder_.CreateAnd(bits, builder_.CreateNot(partners));
    return builder_.CreateAnd(same, builder_.CreateIsNull(builder_.CreateOr(missing, strangers)));
}

Value* LockstepEmitter::answer(const MeetingPoint& point) {
    switch (point.kind) {
    case devlib::kMeetVote:
        return answerVote(point);
    case devlib::kMeetShuffle:
        return answerShuffle(point);
    case devlib::kMeetReduce:
        return answerReduce(point);
    default:
        return answerByHelper(point);
    }
}

Value* LockstepEmitter::answerVote(const MeetingPoint& point) {
    Value* none = llvm::Constant::getNullValue(mask_->getType());
    Value* bits = maskBits(mask_);
    Value* ballot =
        maskBits(select(mask_, builder_.CreateIsNotNull(wide(point.call->getArgOperand(3))), none));
    Value* result = ballot;
    if (point.mode == 0)
        result = builder_.CreateICmpEQ(ballot, bits);
    else if (point.mode == 1)
        result = builder_.CreateIsNotNull(ballot);
    else if (point.mode == 2)
        result =
            builder_.CreateOr(builder_.CreateIsNull(ballot), builder_.CreateICmpEQ(ballot, bits));
    return splat(builder_.CreateZExt(result, builder_.getInt32Ty()));
}

Value* LockstepEmitter::answerShuffle(const MeetingPoint& point) {
    const auto* distance = dyn_cast<llvm::ConstantInt>(point.call->getArgOperand(3));
    const auto* control = dyn_cast<llvm::ConstantInt>(point.call->getArgOperand(4));
    if (!distance || !control)
        return answerByHelper(point);
    // The source lane of each value is constant.
    llvm::SmallVector<int, kLanes> sources;
    llvm::SmallVector<llvm::Constant*, kLanes> valid;
    for (unsigned lane = 0; lane < kLanes; ++lane) {
        const ShuffleSource source =
            shuffleSource(point.mode, lane, uint32_t(distance->getZExtValue()),
                          uint32_t(control->getZExtValue()));
        sources.push_back(int(source.lane));
        valid.push_back(builder_.getInt64(uint64_t(source.isValid) << 32));
    }
    Value* own = wide(point.call->getArgOperand(2));
    Value* theirs = builder_.CreateShuffleVector(own, sources);
    Value* isThere = builder_.CreateShuffleVector(mask_, sources);
    Value* result =
        builder_.CreateZExt(select(isThere, theirs, own), wideType(builder_.getInt64Ty()));
    return builder_.CreateOr(result, llvm::ConstantVector::get(valid));
}

Value* LockstepEmitter::answerReduce(const MeetingPoint& point) {
    using llvm::Intrinsic::ID;
    struct Operation {
        ID id;
        uint32_t neutral;
    };
    static constexpr Operation kOperations[] = {
        {llvm::Intrinsic::vector_reduce_add, 0},
        {llvm::Intrinsic::vector_reduce_and, ~0u},
        {llvm::Intrinsic::vector_reduce_or, 0},
        {llvm::Intrinsic::vector_reduce_xor, 0},
        {llvm::Intrinsic::vector_reduce_smin, 0x7fffffff},
        {llvm::Intrinsic::vector_reduce_umin, ~0u},
        {llvm::Intrinsic::vector_reduce_smax, 0x80000000},
        {llvm::Intrinsic::vector_reduce_umax, 0},
    };
    const Operation& operation = kOperations[point.mode & 7];
    Value* values = select(mask_, wide(point.call->getArgOperand(3)),
                           splat(builder_.getInt32(operation.neutral)));
    return splat(builder_.CreateUnaryIntrinsic(operation.id, values));
}

// From the operands in the warp to the results there.
void LockstepEmitter::callHelper(const MeetingPoint& point) {
    const uint32_t what = point.kind << devlib::kPointBits | point.mode << devlib::kModeShift;
    Value* bits = maskBits(mask_);
    callRunTime("sunstone_lockstep_answer", builder_.getVoidTy(),
                {warp_, builder_.getInt32(what), bits, bits});
}

Value* LockstepEmitter::answerByHelper(const MeetingPoint& point) {
    storeOperands(point);
    callHelper(point);
    Value* result = builder_.CreateAlignedLoad(
        wideType(builder_.getInt64Ty()), field(offsetof(LockstepWarp, result)), llvm::Align(64));
    if (point.call->getType()->isIntegerTy(32))
        return builder_.CreateTrunc(result, wideType(builder_.getInt32Ty()));
    return result;
}

} // namespace sunstone::compiler
