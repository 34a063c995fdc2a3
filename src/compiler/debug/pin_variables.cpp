// SPDX-License-Identifier: Apache-2.0
// Memory for variables, at debug level FULL; see debug_info.h.
#include "compiler/debug/debug_info.h"

#include "devlib/abi.h"

#include <llvm/BinaryFormat/Dwarf.h>

#include <set>

namespace sunstone::compiler {

namespace {

using llvm::DbgVariableRecord;
using VariableKey = std::pair<llvm::DILocalVariable*, llvm::DILocation*>; // and the inlined call

// Bits of the variable that a record's value covers; none if the expression does more than select a
// part.
std::optional<std::pair<uint64_t, uint64_t>> coveredBits(const DbgVariableRecord& record) {
    const llvm::DIExpression* expression = record.getExpression();
    const auto fragment = expression->getFragmentInfo();
    if (expression->getNumElements() > (fragment ? 3u : 0u))
        return std::nullopt;
    const uint64_t size = record.getVariable()->getSizeInBits().value_or(0);
    return fragment ? std::make_pair(fragment->OffsetInBits, fragment->SizeInBits)
                    : std::make_pair(uint64_t(0), size);
}

void storeValue(DbgVariableRecord& record, llvm::AllocaInst* memory,
                const llvm::DataLayout& layout) {
    const auto bits = coveredBits(record);
    if (!bits || record.isKillLocation() || record.hasArgList())
        return;
    llvm::Value* value = record.getVariableLocationOp(0);
    if (!value || !value->getType()->isSized() || bits->first % 8 != 0 ||
        layout.getTypeSizeInBits(value->getType()) > bits->second)
        return;
    llvm::Instruction* before = record.getMarker()->MarkedInstr;
    if (!before)
        return;
    if (llvm::isa<llvm::PHINode>(before))
        before = &*before->getParent()->getFirstInsertionPt();
    llvm::IRBuilder<> builder(before);
    builder.SetCurrentDebugLocation(llvm::DebugLoc()); // belongs to no line
    llvm::Value* place =
        builder.CreateConstInBoundsGEP1_64(builder.getInt8Ty(), memory, bits->first / 8);
    builder.CreateAlignedStore(value, place, llvm::Align(1), true);
}

void pinVariablesOf(llvm::Function& function) {
    std::map<VariableKey, std::vector<DbgVariableRecord*>> found;
    std::vector<VariableKey> order;
    for (llvm::BasicBlock& block : function)
        for (llvm::Instruction& instruction : block)
            for (DbgVariableRecord& record : llvm::filterDbgVars(instruction.getDbgRecordRange())) {
                if (!record.isDbgValue())
                    continue;
                const VariableKey key = {record.getVariable(), record.getDebugLoc().getInlinedAt()};
                auto& list = found[key];
                if (list.empty())
                    order.push_back(key);
                list.push_back(&record);
            }
    const llvm::DataLayout& layout = function.getDataLayout();
    llvm::DIBuilder builder(*function.getParent(), false);
    llvm::BasicBlock& entry = function.getEntryBlock();
    for (const VariableKey& key : order) {
        const uint64_t bits = key.first->getSizeInBits().value_or(0);
        constexpr uint64_t kMostBits = 1 << 16;
        if (bits == 0 || bits % 8 != 0 || bits > kMostBits)
            continue;
        llvm::IRBuilder<> top(&entry, entry.begin());
        auto* memory = top.CreateAlloca(llvm::ArrayType::get(top.getInt8Ty(), bits / 8));
        memory->setAlignment(llvm::Align(16));
        std::vector<DbgVariableRecord*>& records = found[key];
        for (DbgVariableRecord* record : records)
            storeValue(*record, memory, layout);
        llvm::DILocation* location = records.front()->getDebugLoc();
        llvm::Instruction* first = &*entry.getFirstNonPHIOrDbgOrAlloca();
        builder.insertDeclare(memory, key.first, builder.createExpression(), location, first);
        for (DbgVariableRecord* record : records)
            record->eraseFromParent();
    }
}

// The scopes of a function's code: its own, and one for each inlined call.
std::set<std::pair<llvm::DISubprogram*, llvm::DILocation*>> scopesOf(llvm::Function& function) {
    std::set<std::pair<llvm::DISubprogram*, llvm::DILocation*>> scopes;
    for (llvm::BasicBlock& block : function)
        for (llvm::Instruction& instruction : block)
            for (llvm::DILocation* at = instruction.getDebugLoc(); at; at = at->getInlinedAt())
                scopes.emplace(at->getScope()->getSubprogram(), at->getInlinedAt());
    return scopes;
}

// Launch parameters have no fixed address, because each launch has its own. Every scope of the
// function's code gets a local variable of their name, in the memory of this launch.
void showLaunchParams(DebugInfo& info, llvm::Function& function) {
    std::vector<std::pair<llvm::DILocalVariable*, llvm::DILocation*>> variables;
    for (const auto& [scope, inlinedAt] : scopesOf(function))
        if (llvm::DILocalVariable* variable = info.launchParamsIn(scope))
            variables.emplace_back(variable, inlinedAt);
    if (variables.empty())
        return;
    llvm::BasicBlock& entry = function.getEntryBlock();
    llvm::IRBuilder<> builder(&entry, entry.begin());
    llvm::Type* const pointer = builder.getPtrTy();
    llvm::AllocaInst* const address = builder.CreateAlloca(pointer);
    builder.SetInsertPoint(&*entry.getFirstNonPHIOrDbgOrAlloca());
    const auto load = [&](llvm::Value* from, size_t offset) {
        return builder.CreateLoad(
            pointer, builder.CreateConstInBoundsGEP1_64(builder.getInt8Ty(), from, offset));
    };
    llvm::Value* const launch = load(function.getArg(0), offsetof(devlib::RayState, launch));
    llvm::Instruction* const stored =
        builder.CreateStore(load(launch, offsetof(devlib::LaunchState, params)), address, true);
    llvm::DIBuilder debug(*function.getParent(), false);
    for (const auto& [variable, inlinedAt] : variables)
        debug.insertDeclare(address, variable, debug.createExpression({llvm::dwarf::DW_OP_deref}),
                            llvm::DILocation::get(function.getContext(), variable->getLine(), 0,
                                                  variable->getScope(), inlinedAt),
                            stored->getNextNode());
}

} // namespace

void pinVariables(Unit& unit) {
    for (llvm::Function& function : unit.module()) {
        if (function.isDeclaration() || !function.getSubprogram())
            continue;
        pinVariablesOf(function);
        if (!unit.flavor().isKernels() && function.arg_size() != 0)
            showLaunchParams(unit.debugInfo(), function);
    }
}

} // namespace sunstone::compiler
