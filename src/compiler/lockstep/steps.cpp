// SPDX-License-Identifier: Apache-2.0
// See steps.h.
#include "compiler/lockstep/steps.h"

#include "devlib/abi.h"

#include <llvm/Analysis/ValueTracking.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/Instructions.h>
#include <llvm/IR/Module.h>
#include <llvm/IR/Operator.h>

#include <vector>

namespace sunstone::compiler {

using llvm::dyn_cast;
using llvm::Instruction;
using llvm::isa;
using llvm::Value;

namespace {

// The origin of an address.
struct Root {
    // A variable, or the argument from which a load at `offset` reads the base: a parameter of the
    // kernel, or the base of shared memory in the thread. Null: unknown.
    const Value* base = nullptr;
    int64_t offset = 0;

    bool mayBe(const Root& other) const {
        return !base || !other.base || (base == other.base && offset == other.offset);
    }
};

class Accesses {
public:
    explicit Accesses(const llvm::Function& kernel)
        : kernel_(kernel), layout_(kernel.getParent()->getDataLayout()) {
        for (const Instruction& instruction : llvm::instructions(kernel))
            note(instruction);
    }

    bool countOnSteps(bool hasBarriers) const {
        if (hasVolatile_ || (loadsShared_ && storesShared_ && !hasBarriers))
            return true;
        for (const Root& atomic : atomics_)
            for (const Root& plain : plain_)
                if (atomic.mayBe(plain))
                    return true;
        return false;
    }

private:
    void note(const Instruction& instruction) {
        const Value* address = llvm::getLoadStorePointerOperand(&instruction);
        if (const auto* update = dyn_cast<llvm::AtomicRMWInst>(&instruction))
            address = update->getPointerOperand();
        else if (const auto* exchange = dyn_cast<llvm::AtomicCmpXchgInst>(&instruction))
            address = exchange->getPointerOperand();
        if (!address)
            return;
        const Value* object = llvm::getUnderlyingObject(address, 0);
        if (isa<llvm::AllocaInst, llvm::Argument>(object)) // its own memory; a parameter
            return;
        const Root root = rootOf(address, 0);
        hasVolatile_ |= instruction.isVolatile();
        if (root.base == kernel_.getArg(0)) {
            loadsShared_ |= instruction.mayReadFromMemory();
            storesShared_ |= instruction.mayWriteToMemory();
        }
        (instruction.isAtomic() ? atomics_ : plain_).push_back(root);
    }

    // Follows sums to the term that is an address.
    Root rootOf(const Value* value, unsigned depth) const {
        constexpr unsigned kDeep = 24;
        if (isa<llvm::GlobalVariable>(value))
            return {value, 0};
        if (depth > kDeep)
            return {};
        if (const auto* load = dyn_cast<llvm::LoadInst>(value)) {
            llvm::APInt offset(64, 0);
            const Value* base =
                load->getPointerOperand()->stripAndAccumulateConstantOffsets(layout_, offset, true);
            const bool isAddress = layout_.getTypeSizeInBits(load->getType()) == 64;
            return isAddress && isa<llvm::Argument>(base) ? Root{base, offset.getSExtValue()}
                                                          : Root{};
        }
        const auto* instruction = dyn_cast<llvm::Operator>(value);
        if (!instruction)
            return {};
        switch (instruction->getOpcode()) {
        case Instruction::GetElementPtr:
        case Instruction::IntToPtr:
        case Instruction::PtrToInt:
        case Instruction::BitCast:
        case Instruction::ZExt: // shared addresses have 32 bits
        case Instruction::Trunc:
        case Instruction::Freeze:
            return rootOf(instruction->getOperand(0), depth + 1);
        case Instruction::Add:
        case Instruction::Or:
        case Instruction::Sub: {
            const Root first = rootOf(instruction->getOperand(0), depth + 1);
            return first.base ? first : rootOf(instruction->getOperand(1), depth + 1);
        }
        default:
            return {};
        }
    }

    const llvm::Function& kernel_;
    const llvm::DataLayout& layout_;
    std::vector<Root> atomics_, plain_;
    bool hasVolatile_ = false, loadsShared_ = false, storesShared_ = false;
};

} // namespace

bool countsOnSteps(const llvm::Function& kernel, bool hasBarriers) {
    return Accesses(kernel).countOnSteps(hasBarriers);
}

} // namespace sunstone::compiler
