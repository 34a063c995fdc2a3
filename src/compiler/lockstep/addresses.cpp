// SPDX-License-Identifier: Apache-2.0
// LockstepEmitter: addresses computed from an index.
//
// Nearly all addresses are base + index * size, with an extended 32-bit index. The lanes' addresses
// are consecutive if the indices are. Comparing indices takes half as many vectors as comparing
// addresses. Whole addresses are computed only if the comparison fails.
#include "compiler/lockstep/emit.h"

#include <llvm/IR/Operator.h>

namespace sunstone::compiler {

using llvm::BasicBlock;
using llvm::cast;
using llvm::dyn_cast;
using llvm::Instruction;
using llvm::isa;
using llvm::Value;

bool LockstepEmitter::findIndex(Value* address, IndexedAddress& found) const {
    const auto isConstant = [](const Value* value, uint64_t& number) {
        const auto* constant = dyn_cast<llvm::ConstantInt>(value);
        number = constant ? constant->getZExtValue() : 0;
        return constant != nullptr;
    };
    for (;;) {
        auto* step = dyn_cast<Instruction>(address);
        if (!step || plan_.isInPrologue(step))
            return false;
        // The operands must be available: defined in this block, or in the prologue.
        for (const Value* used : step->operands())
            if (isa<Instruction>(used) && step->getParent() != block_ &&
                (isUniform(used) ? !plan_.isInPrologue(used)
                                 : isa<llvm::CastInst>(step) && used->getType()->isIntegerTy(32) &&
                                       !plan_.isInPrologue(used)))
                return false;
        found.chain.push_back(step);
        uint64_t number = 0;
        if (isa<llvm::SExtInst, llvm::ZExtInst>(step)) {
            found.extension = cast<llvm::CastInst>(step);
            return step->getType()->isIntegerTy(64) &&
                   step->getOperand(0)->getType()->isIntegerTy(32);
        }
        if (isa<llvm::IntToPtrInst, llvm::PtrToIntInst>(step)) {
            if (layout_.getTypeSizeInBits(step->getType()) != 64)
                return false;
            address = step->getOperand(0);
        } else if (step->getOpcode() == Instruction::Add) {
            const unsigned uniform = isUniform(step->getOperand(0)) ? 0 : 1;
            if (!isUniform(step->getOperand(uniform)))
                return false;
            address = step->getOperand(1 - uniform);
        } else if (step->getOpcode() == Instruction::Shl &&
                   isConstant(step->getOperand(1), number) && number < 16) {
            found.scale <<= number;
            address = step->getOperand(0);
        } else if (step->getOpcode() == Instruction::Mul &&
                   isConstant(step->getOperand(1), number) && number - 1 < 1 << 16) {
            found.scale *= number;
            address = step->getOperand(0);
        } else if (auto* element = dyn_cast<llvm::GetElementPtrInst>(step);
                   element && element->getNumIndices() == 1) {
            Value* index = element->getOperand(1);
            if (isUniform(index)) {
                address = element->getPointerOperand();
                continue;
            }
            if (!isUniform(element->getPointerOperand()))
                return false;
            found.scale *= layout_.getTypeAllocSize(element->getSourceElementType());
            address = index;
        } else {
            return false;
        }
        if (!address->getType()->isIntegerTy(64) && !address->getType()->isPointerTy())
            return false;
    }
}

// Finds the indexed addresses of a block, and the instructions that only these addresses use.
void LockstepEmitter::findAddresses(BasicBlock& block) {
    indexed_.clear();
    late_.clear();
    llvm::DenseSet<const Instruction*> chains;
    for (Instruction& instruction : block) {
        Value* pointer = llvm::getLoadStorePointerOperand(&instruction);
        if (!pointer || isUniform(pointer) || !isNearPossible(instruction))
            continue;
        IndexedAddress found;
        if (!findIndex(pointer, found))
            continue;
        for (const Instruction* step : found.chain)
            if (step->getParent() == &block)
                chains.insert(step);
        indexed_[pointer] = std::move(found);
    }
    for (Instruction& instruction : llvm::reverse(block)) {
        if (!chains.contains(&instruction))
            continue;
        const bool isLate = llvm::all_of(instruction.users(), [&](const llvm::User* user) {
            if (late_.contains(user))
                return true;
            const auto* access = dyn_cast<Instruction>(user);
            const auto* store = dyn_cast<llvm::StoreInst>(user);
            return access->getParent() == &block && indexed_.contains(&instruction) &&
                   llvm::getLoadStorePointerOperand(access) == &instruction &&
                   isNearPossible(*access) && !(store && store->getValueOperand() == &instruction);
        });
        if (isLate)
            late_.insert(&instruction);
    }
}

LockstepEmitter::Nearness LockstepEmitter::nearnessOf(const IndexedAddress& address,
                                                      uint64_t bytes) {
    Nearness nearness;
    if (bytes % address.scale != 0)
        return nearness; // never
    const uint64_t step = bytes / address.scale, span = step * (kLanes - 1);
    const bool isSigned = isa<llvm::SExtInst>(address.extension);
    Value* indices = wide(address.extension->getOperand(0));
    Value* first = builder_.CreateExtractElement(indices, uint64_t(0));
    nearness.fits = builder_.CreateICmpEQ(
        indices, builder_.CreateAdd(splat(first), lanes(builder_.getInt32Ty(), step)));
    // The last index is greater than the first, so adding the span does not wrap.
    nearness.bound =
        isSigned ? builder_.CreateICmpSLE(first, builder_.getInt32(uint32_t(0x7fffffff - span)))
                 : builder_.CreateICmpULE(first, builder_.getInt32(uint32_t(0xffffffff - span)));
    nearness.first = addressAt(address, first);
    return nearness;
}

// Computes the address for this index; for null, the address without the contribution of the index.
Value* LockstepEmitter::addressAt(const IndexedAddress& address, Value* index) {
    const bool isSigned = isa<llvm::SExtInst>(address.extension);
    Value* made = nullptr;
    Value* before = nullptr;
    for (Instruction* step : llvm::reverse(address.chain)) {
        if (step == address.extension) {
            if (!index)
                made = llvm::Constant::getNullValue(step->getType());
            else
                made = isSigned ? builder_.CreateSExt(index, step->getType())
                                : builder_.CreateZExt(index, step->getType());
        } else {
            Instruction* copy = step->clone();
            for (llvm::Use& use : copy->operands())
                use.set(use.get() == before ? made : scalar(use.get()));
            copy->dropPoisonGeneratingFlags();
            copy->setDebugLoc(llvm::DebugLoc());
            made = builder_.Insert(copy);
        }
        before = step;
    }
    return made;
}

// The addresses of all lanes for a gather or scatter. Instructions take one shared address and a
// 32-bit index per lane, which need half the registers of whole addresses.
Value* LockstepEmitter::farAddresses(Value* pointer) {
    const auto found = indexed_.find(pointer);
    if (found == indexed_.end())
        return wide(pointer);
    const IndexedAddress& address = found->second;
    if (!llvm::isPowerOf2_64(address.scale) || address.scale > 8)
        return wide(pointer);
    Value* base = addressAt(address, nullptr);
    if (!base->getType()->isPointerTy())
        base = builder_.CreateIntToPtr(base, builder_.getPtrTy());
    Value* indices = wide(address.extension->getOperand(0));
    llvm::Type* element = builder_.getIntNTy(unsigned(address.scale) * 8);
    if (isa<llvm::ZExtInst>(address.extension)) { // gathers take signed indices
        constexpr uint32_t kHalf = uint32_t(1) << 31;
        indices = builder_.CreateXor(indices, splat(builder_.getInt32(kHalf)));
        base = builder_.CreateGEP(element, base, builder_.getInt64(kHalf));
    }
    indices = builder_.CreateSExt(indices, wideType(builder_.getInt64Ty()));
    return builder_.CreateGEP(element, base, indices);
}

} // namespace sunstone::compiler
