// SPDX-License-Identifier: Apache-2.0
// RegisterPass: see passes.h. Variables in .param space count as registers. If a register has one
// definition besides its first value, and the definition dominates every read, the definition
// replaces the reads. For other registers, LLVM's SSAUpdater searches backwards from each read for
// the reaching definitions.
#include "compiler/passes/passes.h"

#include <llvm/IR/DataLayout.h>
#include <llvm/IR/DebugInfo.h>
#include <llvm/IR/Dominators.h>
#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/Instructions.h>
#include <llvm/Transforms/Utils/SSAUpdater.h>

#include <vector>

namespace sunstone::compiler {

namespace {

// The accesses of a register: loads and stores of all its bytes, as numbers.
struct Accesses {
    Accesses(llvm::AllocaInst& memory, const llvm::DataLayout& layout) {
        const auto size = memory.getAllocationSizeInBits(layout);
        for (llvm::User* user : memory.users()) {
            auto* load = llvm::dyn_cast<llvm::LoadInst>(user);
            auto* store = llvm::dyn_cast<llvm::StoreInst>(user);
            const bool isAccess =
                load ? load->isSimple()
                     : store && store->isSimple() && store->getPointerOperand() == &memory;
            if (!isAccess)
                return;
            llvm::Type* accessed = llvm::getLoadStoreType(user);
            const bool isNumber = accessed->isIntegerTy() || accessed->isFloatingPointTy();
            if (!isNumber || layout.getTypeAllocSizeInBits(accessed) != size ||
                (type && type->getPrimitiveSizeInBits() != accessed->getPrimitiveSizeInBits()))
                return;
            if (!type)
                type = accessed;
            all.push_back(llvm::cast<llvm::Instruction>(user));
        }
        isRegister = type != nullptr;
    }

    // Makes all accesses of the same type.
    void unify() {
        for (llvm::Instruction*& access : all) {
            if (llvm::getLoadStoreType(access) != type) {
                llvm::IRBuilder<> builder(access);
                llvm::Instruction* made = nullptr;
                if (auto* load = llvm::dyn_cast<llvm::LoadInst>(access)) {
                    made = builder.CreateLoad(type, load->getPointerOperand());
                    load->replaceAllUsesWith(builder.CreateBitCast(made, load->getType()));
                } else {
                    auto* store = llvm::cast<llvm::StoreInst>(access);
                    made =
                        builder.CreateStore(builder.CreateBitCast(store->getValueOperand(), type),
                                            store->getPointerOperand());
                }
                access->eraseFromParent();
                access = made;
            }
            if (auto* load = llvm::dyn_cast<llvm::LoadInst>(access))
                loads.push_back(load);
            else
                stores.push_back(llvm::cast<llvm::StoreInst>(access));
        }
    }

    bool isRegister = false;
    llvm::Type* type = nullptr;
    llvm::SmallVector<llvm::Instruction*, 8> all;
    llvm::SmallVector<llvm::LoadInst*, 8> loads;
    llvm::SmallVector<llvm::StoreInst*, 8> stores;
};

// The only store besides that of the first value, if it dominates all loads.
llvm::StoreInst* onlyDefinition(const Accesses& accesses, const llvm::DominatorTree& tree,
                                const llvm::BasicBlock& entry) {
    llvm::StoreInst* only = nullptr;
    for (llvm::StoreInst* store : accesses.stores) {
        if (store->getParent() == &entry && accesses.stores.size() > 1)
            continue;
        if (only)
            return nullptr;
        only = store;
    }
    if (!only)
        return nullptr;
    for (const llvm::LoadInst* load : accesses.loads)
        if (!tree.dominates(only, load))
            return nullptr;
    return only;
}

} // namespace

llvm::PreservedAnalyses RegisterPass::run(llvm::Function& function,
                                          llvm::FunctionAnalysisManager& analyses) {
    std::vector<std::pair<llvm::AllocaInst*, Accesses>> registers;
    for (llvm::Instruction& instruction : function.getEntryBlock()) {
        auto* memory = llvm::dyn_cast<llvm::AllocaInst>(&instruction);
        if (!memory || memory->isArrayAllocation() || !llvm::findDbgDeclares(memory).empty() ||
            !llvm::findDVRDeclares(memory).empty())
            continue;
        Accesses accesses(*memory, function.getDataLayout());
        if (accesses.isRegister)
            registers.emplace_back(memory, std::move(accesses));
    }
    if (registers.empty())
        return llvm::PreservedAnalyses::all();
    // All registers are unified before the first query of the instruction order, because added
    // instructions make LLVM renumber the block.
    for (auto& [memory, accesses] : registers)
        accesses.unify();
    const auto& tree = analyses.getResult<llvm::DominatorTreeAnalysis>(function);
    for (auto& [memory, accesses] : registers) {
        if (llvm::StoreInst* store = onlyDefinition(accesses, tree, function.getEntryBlock())) {
            for (llvm::LoadInst* load : accesses.loads)
                load->replaceAllUsesWith(store->getValueOperand());
            for (llvm::Instruction* access : accesses.all)
                access->eraseFromParent();
        } else {
            llvm::SSAUpdater values;
            llvm::LoadAndStorePromoter(accesses.all, values).run(accesses.all);
        }
        memory->eraseFromParent();
    }
    llvm::PreservedAnalyses kept;
    kept.preserveSet<llvm::CFGAnalyses>();
    return kept;
}

} // namespace sunstone::compiler
