// SPDX-License-Identifier: Apache-2.0
// See tree_constants.h.
#include "compiler/optix7/tree_constants.h"

#include "ptx/opcodes/opcode.h"

namespace sunstone::compiler {

namespace {

using ptx::OperandKind;
using ptx::Operation;
using ptx::StatementKind;

bool isLoad(const ptx::Instruction& instruction) {
    return instruction.facts->operation == Operation::kLoad && instruction.guard < 0 &&
           instruction.operands.size() == 2 && instruction.types.size() == 1 &&
           instruction.operands[1].kind == OperandKind::kAddress && !instruction.has("volatile");
}

// Parameters of calls are in a space of their own.
bool isStore(const ptx::Instruction& instruction) {
    return instruction.facts->operation == Operation::kStore && !instruction.has("param");
}

// Calls of the API's functions leave the caller's memory alone, as arithmetic does.
bool leavesMemory(const ptx::Instruction& instruction) {
    if (instruction.facts->syntax == ptx::Syntax::kCall)
        return instruction.target.kind == OperandKind::kSymbol &&
               instruction.target.name.starts_with("_optix_");
    const ptx::Opcode& facts = *instruction.facts;
    if (instruction.isForeign || facts.operation == Operation::kUnknown)
        return false;
    if (facts.operation == Operation::kLoad || facts.operation == Operation::kStore)
        return !isStore(instruction);
    return facts.native != ptx::Native::kEffects && facts.native != ptx::Native::kOrders &&
           facts.native != ptx::Native::kWarpMemory && facts.native != ptx::Native::kStack;
}

struct Bytes {
    int64_t begin = 0, end = 0;
};

Bytes bytesOf(const ptx::Instruction& instruction, const ptx::Operand& address) {
    int64_t size = 0;
    for (const ptx::Type type : instruction.types)
        size = ptx::sizeOf(type);
    const ptx::Operand& value =
        instruction.operands[isStore(instruction) ? 1 : 0]; // several of them in a vector
    if (value.kind == OperandKind::kVector)
        size *= int64_t(value.elements.size());
    return {address.offset, address.offset + size};
}

} // namespace

TreeConstants::TreeConstants(const ptx::Function& function)
    : function_(function), definitions_(function.registers.size(), 0) {
    for (size_t i = 0; i < function.body.size(); ++i) {
        if (function.body[i].kind != StatementKind::kInstruction)
            continue;
        const ptx::Instruction& instruction = function.body[i].instruction;
        if (!instruction.operands.empty())
            define(instruction.operands[0], i);
        for (const ptx::Operand& result : instruction.results)
            define(result, i);
        for (const ptx::Operand& operand : instruction.operands)
            if (operand.kind == OperandKind::kLabel)
                targets_.insert(operand.index);
    }
    for (const ptx::BranchTargets& list : function.branchTargets)
        targets_.insert(list.labels.begin(), list.labels.end());
}

void TreeConstants::define(const ptx::Operand& target, size_t statement) {
    for (const ptx::Operand& element : target.elements)
        define(element, statement);
    if (target.kind != OperandKind::kRegister || target.index >= definitions_.size())
        return;
    ++definitions_[target.index];
    statements_[target.index] = statement;
}

// Null unless there is exactly one definition, without a guard.
const ptx::Instruction* TreeConstants::definitionOf(const ptx::Operand& operand) const {
    if (operand.kind != OperandKind::kRegister || operand.component >= 0 ||
        operand.index >= definitions_.size() || definitions_[operand.index] != 1)
        return nullptr;
    const ptx::Instruction& instruction = function_.body[statements_.at(operand.index)].instruction;
    const bool isTarget = !instruction.operands.empty() &&
                          instruction.operands[0].kind == OperandKind::kRegister &&
                          instruction.operands[0].index == operand.index;
    return instruction.guard < 0 && isTarget ? &instruction : nullptr;
}

std::optional<uint32_t> TreeConstants::valueOf(const ptx::Operand& operand) const {
    constexpr unsigned kMostSteps = 32;
    const ptx::Operand* at = &operand;
    for (unsigned step = 0; step < kMostSteps; ++step) {
        if (at->kind == OperandKind::kInteger)
            return uint32_t(at->integer);
        const ptx::Instruction* definition = definitionOf(*at);
        if (!definition)
            return std::nullopt;
        if (definition->facts->operation == Operation::kMove && definition->operands.size() == 2)
            at = &definition->operands[1];
        else if (isLoad(*definition))
            at = storedBefore(statements_.at(at->index));
        else
            return std::nullopt;
        if (!at)
            return std::nullopt;
    }
    return std::nullopt;
}

// The operand that the nearest store before the load, in straight-line code, writes to the loaded
// bytes. Null if an instruction in between may write them. Two addresses are known to differ only
// if they have the same base register, which has one definition.
const ptx::Operand* TreeConstants::storedBefore(size_t load) const {
    const ptx::Instruction& reader = function_.body[load].instruction;
    const ptx::Operand& from = reader.operands[1];
    if (!from.name.empty() || from.index >= definitions_.size() || definitions_[from.index] != 1)
        return nullptr;
    const Bytes wanted = bytesOf(reader, from);
    for (size_t i = load; i-- > 0;) {
        if (function_.body[i].kind == StatementKind::kLabel) {
            if (targets_.count(function_.body[i].label) != 0)
                return nullptr;
            continue;
        }
        const ptx::Instruction& before = function_.body[i].instruction;
        if (!isStore(before)) {
            if (!leavesMemory(before))
                return nullptr;
            continue;
        }
        if (before.guard >= 0 || before.operands.size() != 2 || before.types.size() != 1 ||
            before.operands[0].kind != OperandKind::kAddress || !before.operands[0].name.empty() ||
            before.operands[0].index != from.index)
            return nullptr;
        const Bytes stored = bytesOf(before, before.operands[0]);
        if (stored.end <= wanted.begin || stored.begin >= wanted.end)
            continue;
        const bool isSame = stored.begin == wanted.begin && stored.end == wanted.end;
        return isSame ? &before.operands[1] : nullptr;
    }
    return nullptr;
}

} // namespace sunstone::compiler
