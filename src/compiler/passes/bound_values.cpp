// SPDX-License-Identifier: Apache-2.0
// See bound_values.h.
#include "compiler/passes/bound_values.h"

#include <llvm/Analysis/ConstantFolding.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/Instructions.h>
#include <llvm/IR/Operator.h>

namespace sunstone::compiler {

namespace {

using llvm::Value;

class Substitution {
public:
    Substitution(Unit& unit, const std::vector<BoundValue>& values)
        : layout_(unit.module().getDataLayout()), values_(values), counts_(values.size()) {}

    void run(llvm::Function& function) {
        std::vector<llvm::LoadInst*> loads;
        for (llvm::Instruction& instruction : llvm::instructions(function))
            if (auto* load = llvm::dyn_cast<llvm::LoadInst>(&instruction))
                loads.push_back(load);
        for (llvm::LoadInst* load : loads) {
            uint64_t offset = 0;
            Value* base = baseOf(load->getPointerOperand(), offset);
            if (isField(base, function, offsetof(devlib::LaunchState, params)))
                replace(*load, offset);
        }
    }

    const std::vector<uint32_t>& counts() const { return counts_; }

private:
    Value* baseOf(Value* pointer, uint64_t& offset) const {
        llvm::APInt bytes(64, 0);
        Value* base = pointer->stripAndAccumulateConstantOffsets(layout_, bytes, true);
        offset = bytes.getZExtValue();
        return base;
    }

    // Whether the value is state->launch->FIELD.
    bool isField(Value* value, llvm::Function& function, size_t field) const {
        const auto isLoadAt = [&](Value* loaded, size_t wanted, Value** base) {
            auto* load = llvm::dyn_cast<llvm::LoadInst>(loaded);
            uint64_t offset = 0;
            if (!load || !load->getType()->isPointerTy())
                return false;
            *base = baseOf(load->getPointerOperand(), offset);
            return offset == wanted;
        };
        Value *launch = nullptr, *state = nullptr;
        return isLoadAt(value, field, &launch) &&
               isLoadAt(launch, offsetof(devlib::RayState, launch), &state) &&
               function.arg_size() > 0 && state == function.getArg(0);
    }

    // Looks up each byte of the load among the bound ones, and replaces the load if all are found.
    void replace(llvm::LoadInst& load, uint64_t offset) {
        llvm::Type* type = load.getType();
        const uint64_t size = layout_.getTypeStoreSize(type);
        std::vector<uint8_t> bytes(size);
        std::set<size_t> sources;
        for (uint64_t i = 0; i < size; ++i) {
            const size_t source = sourceOf(offset + i);
            if (source == values_.size())
                return;
            bytes[i] = values_[source].bytes[offset + i - values_[source].offset];
            sources.insert(source);
        }
        llvm::Constant* data =
            llvm::ConstantDataArray::get(load.getContext(), llvm::ArrayRef<uint8_t>(bytes));
        llvm::Constant* constant = llvm::ConstantFoldLoadFromConst(data, type, layout_);
        if (!constant)
            return;
        for (size_t source : sources)
            ++counts_[source];
        load.replaceAllUsesWith(constant);
        load.eraseFromParent();
    }

    size_t sourceOf(uint64_t byte) const {
        for (size_t i = 0; i < values_.size(); ++i)
            if (byte - values_[i].offset < values_[i].bytes.size())
                return i;
        return values_.size();
    }

    const llvm::DataLayout& layout_;
    const std::vector<BoundValue>& values_;
    std::vector<uint32_t> counts_;
};

} // namespace

std::vector<uint32_t> substituteBoundValues(Unit& unit, const std::vector<BoundValue>& values) {
    if (values.empty())
        return {};
    Substitution substitution(unit, values);
    for (llvm::Function& function : unit.module())
        if (!function.isDeclaration())
            substitution.run(function);
    return substitution.counts();
}

} // namespace sunstone::compiler
