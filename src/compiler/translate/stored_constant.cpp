// SPDX-License-Identifier: Apache-2.0
// See stored_constant.h.
#include "compiler/translate/stored_constant.h"

#include "compiler/passes/check_accesses.h"

#include <llvm/IR/DataLayout.h>
#include <llvm/IR/InstrTypes.h>
#include <llvm/IR/Instructions.h>
#include <llvm/IR/IntrinsicInst.h>

#include <optional>

namespace sunstone::compiler {

namespace {

struct Place {
    const llvm::Value* memory = nullptr;
    int64_t begin = 0, end = 0;
};

// Bytes of local memory at a constant place.
std::optional<Place> placeOf(const llvm::Value* address, const llvm::Type* type,
                             const llvm::DataLayout& layout) {
    llvm::APInt offset(64, 0);
    const llvm::Value* memory = address->stripAndAccumulateConstantOffsets(layout, offset, true);
    if (!llvm::isa<llvm::AllocaInst>(memory))
        return std::nullopt;
    const int64_t begin = offset.getSExtValue();
    const auto size = layout.getTypeStoreSize(const_cast<llvm::Type*>(type));
    return Place{memory, begin, begin + int64_t(size.getFixedValue())};
}

// The last store before `load` in its block, if it writes exactly the bytes that `load` reads.
const llvm::StoreInst* lastStore(const llvm::LoadInst& load) {
    const llvm::DataLayout& layout = load.getDataLayout();
    const auto place = placeOf(load.getPointerOperand(), load.getType(), layout);
    if (!place)
        return nullptr;
    for (const llvm::Instruction* i = load.getPrevNode(); i; i = i->getPrevNode()) {
        if (!i->mayWriteToMemory() || llvm::isa<llvm::DbgInfoIntrinsic>(i) || isAccessCheck(*i))
            continue;
        const auto* store = llvm::dyn_cast<llvm::StoreInst>(i);
        if (!store)
            return nullptr;
        const llvm::Type* type = store->getValueOperand()->getType();
        const auto other = placeOf(store->getPointerOperand(), type, layout);
        if (!other)
            return nullptr; // anywhere
        if (other->memory != place->memory || other->end <= place->begin ||
            other->begin >= place->end)
            continue;
        return other->begin == place->begin && type == load.getType() ? store : nullptr;
    }
    return nullptr;
}

} // namespace

const llvm::ConstantInt* storedConstant(const llvm::Value* value) {
    constexpr unsigned kMostCopies = 16; // one for each function that was inlined
    for (unsigned i = 0; i < kMostCopies; ++i) {
        if (const auto* constant = llvm::dyn_cast<llvm::ConstantInt>(value))
            return constant;
        const auto* load = llvm::dyn_cast<llvm::LoadInst>(value);
        const llvm::StoreInst* store = load ? lastStore(*load) : nullptr;
        if (!store)
            return nullptr;
        value = store->getValueOperand();
    }
    return nullptr;
}

} // namespace sunstone::compiler
