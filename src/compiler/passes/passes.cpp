// SPDX-License-Identifier: Apache-2.0
// See passes.h.
#include "compiler/passes/passes.h"

#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/Operator.h>
#include <llvm/Transforms/Utils/Local.h>

#include <map>

namespace sunstone::compiler {

namespace {

using llvm::Value;

// Finds the pointer from which an integer was computed.
class PointerFinder {
public:
    explicit PointerFinder(llvm::Function& function) : builder_(function.getContext()) {}

    // Whether `value` is a pointer plus an offset, through phis and selects.
    bool isPointer(Value* value, unsigned depth = 0) {
        if (depth == 0)
            budget_ = kBudget;
        const auto known = known_.find(value);
        if (known != known_.end())
            return known->second;
        if (depth > kMaxDepth || --budget_ < 0)
            return false;
        if (llvm::isa<llvm::PtrToIntOperator>(value))
            return known_[value] = true;
        auto* instruction = llvm::dyn_cast<llvm::Instruction>(value);
        if (!instruction)
            return false;
        if (instruction->getOpcode() == llvm::Instruction::Add)
            return known_[value] = isPointer(instruction->getOperand(0), depth + 1) !=
                                   isPointer(instruction->getOperand(1), depth + 1);
        if (auto* select = llvm::dyn_cast<llvm::SelectInst>(value))
            return known_[value] = isPointer(select->getTrueValue(), depth + 1) &&
                                   isPointer(select->getFalseValue(), depth + 1);
        if (auto* phi = llvm::dyn_cast<llvm::PHINode>(value)) {
            known_[value] = true; // assumed while its inputs are visited: loops
            bool all = true;
            for (Value* incoming : phi->incoming_values())
                all = all && isPointer(incoming, depth + 1);
            if (!all)
                known_.clear(); // conclusions drawn from the assumption may be wrong
            return known_[value] = all;
        }
        return false;
    }

    Value* pointerOf(Value* value) {
        if (Value*& made = made_[value])
            return made;
        if (auto* cast = llvm::dyn_cast<llvm::PtrToIntOperator>(value))
            return made_[value] = cast->getPointerOperand();
        auto* instruction = llvm::cast<llvm::Instruction>(value);
        if (auto* phi = llvm::dyn_cast<llvm::PHINode>(value)) {
            builder_.SetInsertPoint(phi);
            auto* pointers = builder_.CreatePHI(builder_.getPtrTy(), phi->getNumIncomingValues());
            made_[value] = pointers;
            for (unsigned i = 0; i < phi->getNumIncomingValues(); ++i)
                pointers->addIncoming(pointerOf(phi->getIncomingValue(i)),
                                      phi->getIncomingBlock(i));
            return pointers;
        }
        if (auto* select = llvm::dyn_cast<llvm::SelectInst>(value)) {
            Value* first = pointerOf(select->getTrueValue());
            Value* second = pointerOf(select->getFalseValue());
            builder_.SetInsertPoint(select);
            return made_[value] = builder_.CreateSelect(select->getCondition(), first, second);
        }
        const unsigned base = isPointer(instruction->getOperand(0)) ? 0 : 1;
        Value* pointer = pointerOf(instruction->getOperand(base));
        builder_.SetInsertPoint(instruction);
        return made_[value] = builder_.CreateGEP(builder_.getInt8Ty(), pointer,
                                                 instruction->getOperand(1 - base));
    }

private:
    static constexpr unsigned kMaxDepth = 64;
    static constexpr int kBudget = 1000; // values visited per query
    int budget_ = 0;
    llvm::IRBuilder<> builder_;
    std::map<Value*, bool> known_;
    std::map<Value*, Value*> made_;
};

} // namespace

llvm::PreservedAnalyses PointerPass::run(llvm::Function& function, llvm::FunctionAnalysisManager&) {
    std::vector<llvm::IntToPtrInst*> casts;
    for (llvm::Instruction& instruction : llvm::instructions(function))
        if (auto* cast = llvm::dyn_cast<llvm::IntToPtrInst>(&instruction))
            casts.push_back(cast);
    PointerFinder finder(function);
    bool changed = false;
    for (llvm::IntToPtrInst* cast : casts) {
        Value* address = cast->getOperand(0);
        if (!address->getType()->isIntegerTy(64) || cast->getAddressSpace() != 0)
            continue;
        if (finder.isPointer(address)) {
            cast->replaceAllUsesWith(finder.pointerOf(address));
            cast->eraseFromParent();
            changed = true;
            continue;
        }
        // Constant offsets show that accesses relative to one unknown base do not overlap.
        auto* sum = llvm::dyn_cast<llvm::BinaryOperator>(address);
        if (!sum || sum->getOpcode() != llvm::Instruction::Add ||
            !llvm::isa<llvm::ConstantInt>(sum->getOperand(1)))
            continue;
        llvm::IRBuilder<> builder(sum->getNextNode());
        Value* base = builder.CreateIntToPtr(sum->getOperand(0), builder.getPtrTy());
        cast->replaceAllUsesWith(builder.CreateGEP(builder.getInt8Ty(), base, sum->getOperand(1)));
        cast->eraseFromParent();
        changed = true;
    }
    for (llvm::BasicBlock& block : function)
        if (changed)
            llvm::SimplifyInstructionsInBlock(&block);
    return changed ? llvm::PreservedAnalyses::none() : llvm::PreservedAnalyses::all();
}

} // namespace sunstone::compiler
