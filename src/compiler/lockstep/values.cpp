// SPDX-License-Identifier: Apache-2.0
// LockstepEmitter: the places of values.
#include "compiler/lockstep/emit.h"

namespace sunstone::compiler {

using llvm::cast;
using llvm::dyn_cast;
using llvm::Instruction;
using llvm::isa;
using llvm::Value;

llvm::FixedVectorType* LockstepEmitter::wideType(llvm::Type* type) const {
    return llvm::FixedVectorType::get(type, kLanes);
}

llvm::Type* LockstepEmitter::typeFor(const Value* value) const {
    return isUniform(value) ? value->getType() : wideType(value->getType());
}

llvm::AllocaInst* LockstepEmitter::place(const Instruction& value) {
    llvm::AllocaInst*& made = places_[&value];
    if (!made)
        made = top_.CreateAlloca(typeFor(&value));
    return made;
}

Value* LockstepEmitter::splat(Value* scalar) {
    return builder_.CreateVectorSplat(kLanes, scalar);
}

Value* LockstepEmitter::lanes(llvm::Type* type, uint64_t step) {
    llvm::SmallVector<llvm::Constant*, kLanes> numbers;
    for (unsigned lane = 0; lane < kLanes; ++lane)
        numbers.push_back(llvm::ConstantInt::get(type, lane * step));
    return llvm::ConstantVector::get(numbers);
}

Value* LockstepEmitter::temporary(llvm::Type* type) {
    llvm::AllocaInst* made = top_.CreateAlloca(type);
    made->setAlignment(llvm::Align(64));
    return made;
}

Value* LockstepEmitter::field(size_t offset) {
    return builder_.CreateInBoundsGEP(builder_.getInt8Ty(), warp_, builder_.getInt64(offset));
}

// A uniform value as a scalar.
Value* LockstepEmitter::scalar(Value* value) {
    if (value == source_.getArg(1))
        return params_;
    if (!isa<Instruction>(value))
        return value;
    if (Value* made = here_.lookup(value))
        return made;
    if (Value* made = always_.lookup(value))
        return made;
    return here_[value] = loadUniform(*cast<Instruction>(value));
}

Value* LockstepEmitter::loadUniform(const Instruction& value) {
    const auto shared = shared_.find(&value);
    if (shared == shared_.end())
        return builder_.CreateLoad(value.getType(), place(value));
    Value* from = builder_.CreateConstGEP1_64(builder_.getInt64Ty(), sharedPlace_, shared->second);
    return fromStored(builder_.CreateLoad(storedType(value.getType()), from), value.getType());
}

void LockstepEmitter::storeUniform(const Instruction& value, Value* made) {
    const auto shared = shared_.find(&value);
    if (shared == shared_.end()) {
        builder_.CreateStore(made, place(value));
        return;
    }
    builder_.CreateStore(toStored(made), builder_.CreateConstGEP1_64(builder_.getInt64Ty(),
                                                                     sharedPlace_, shared->second));
}

Value* LockstepEmitter::wide(Value* value) {
    if (isUniform(value))
        return splat(scalar(value));
    if (Value* made = here_.lookup(value))
        return made;
    if (Value* made = always_.lookup(value))
        return made;
    Value* made = nullptr;
    if (value == source_.getArg(0)) { // the threads of the lanes
        needsThreads_ = true;
        made = builder_.CreateGEP(builder_.getInt8Ty(), threads_,
                                  lanes(builder_.getInt64Ty(), sizeof(devlib::KernelThread)));
    } else if (late_.contains(value)) {
        made = widen(*cast<Instruction>(value));
    } else if (byRuns_) {
        const auto& instruction = *cast<Instruction>(value);
        made = fromStored(builder_.CreateAlignedLoad(wideType(storedType(value->getType())),
                                                     arrayOf(instruction), llvm::Align(64)),
                          value->getType());
    } else {
        made = builder_.CreateLoad(wideType(value->getType()), place(*cast<Instruction>(value)));
    }
    here_[value] = made;
    return made;
}

Value* LockstepEmitter::select(Value* mask, Value* first, Value* second) {
    return builder_.CreateSelect(mask, first, second);
}

// Stores a value for other blocks. blend: lanes outside the mask keep their values.
void LockstepEmitter::store(Instruction& value, Value* made, bool blend, Value* mask) {
    if (isUniform(&value))
        return storeUniform(value, made);
    llvm::AllocaInst* into = place(value);
    if (blend)
        made = select(mask, made, builder_.CreateLoad(into->getAllocatedType(), into));
    builder_.CreateStore(made, into);
}

void LockstepEmitter::define(Instruction& instruction, Value* made) {
    if (!made || instruction.getType()->isVoidTy())
        return;
    here_[&instruction] = made;
    for (const llvm::User* user : instruction.users()) {
        const auto* other = cast<Instruction>(user);
        if (other->getParent() == instruction.getParent() && !isa<llvm::PHINode>(other))
            continue;
        store(instruction, made, plan_.outlivesLoop(instruction), mask_);
        return;
    }
}

llvm::Type* LockstepEmitter::storedType(llvm::Type* type) const {
    if (!type->isIntegerTy())
        return type;
    return llvm::IntegerType::get(
        context_, std::max(8u, unsigned(llvm::PowerOf2Ceil(type->getIntegerBitWidth()))));
}

Value* LockstepEmitter::toStored(Value* made) {
    llvm::Type* type = storedType(made->getType()->getScalarType());
    if (type == made->getType()->getScalarType())
        return made;
    return builder_.CreateZExt(made, made->getType()->isVectorTy() ? wideType(type) : type);
}

Value* LockstepEmitter::fromStored(Value* made, llvm::Type* type) {
    if (made->getType()->getScalarType() == type)
        return made;
    return builder_.CreateTrunc(made, made->getType()->isVectorTy() ? wideType(type) : type);
}

void LockstepEmitter::storeMasked(Value* made, Value* address, llvm::Align align, Value* mask) {
    if (hasMasks_) {
        builder_.CreateMaskedStore(made, address, align, mask);
        return;
    }
    Value* old = builder_.CreateAlignedLoad(made->getType(), address, align);
    builder_.CreateAlignedStore(select(mask, made, old), address, align);
}

// The place of the value in a warp's frame: 32 elements.
Value* LockstepEmitter::framePlace(const Instruction& value) {
    const auto [found, isNew] = framePlaces_.try_emplace(&value, frameBytes_);
    if (isNew) {
        uint64_t bytes = layout_.getTypeAllocSize(storedType(value.getType()));
        if (const auto* memory = dyn_cast<llvm::AllocaInst>(&value))
            bytes = llvm::alignTo(memory->getAllocationSize(layout_)->getFixedValue(),
                                  memory->getAlign());
        frameBytes_ += uint32_t((bytes * kLanes + 63) / 64 * 64);
    }
    return builder_.CreateInBoundsGEP(builder_.getInt8Ty(), frame_,
                                      builder_.getInt64(found->second));
}

Value* LockstepEmitter::firstLane(Value* bits) {
    return builder_.CreateBinaryIntrinsic(llvm::Intrinsic::cttz, bits, builder_.getTrue());
}

} // namespace sunstone::compiler
