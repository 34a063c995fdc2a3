// SPDX-License-Identifier: Apache-2.0
// See exchanges.h.
#include "compiler/kernels/exchanges.h"

#include "ptx/opcodes/opcode.h"

#include <algorithm>
#include <map>

namespace sunstone::compiler {

namespace {

using Names = std::set<std::string_view>;

void addShared(const std::vector<ptx::Variable>& variables, Names& names) {
    for (const ptx::Variable& variable : variables)
        if (variable.space == ptx::Space::kShared)
            names.insert(variable.name);
}

bool names(const ptx::Operand& operand, const Names& variables) {
    const bool isNamed =
        operand.kind == ptx::OperandKind::kSymbol || operand.kind == ptx::OperandKind::kAddress;
    if (isNamed && variables.count(operand.name) != 0)
        return true;
    return std::any_of(operand.elements.begin(), operand.elements.end(),
                       [&](const ptx::Operand& element) { return names(element, variables); });
}

bool mayExchange(const ptx::Instruction& instruction, const Names& shared) {
    if (instruction.has("volatile") && !instruction.has("local"))
        return true;
    if (instruction.facts->operation == ptx::Operation::kAtomic)
        return true;
    const auto any = [&](const std::vector<ptx::Operand>& operands) {
        return std::any_of(operands.begin(), operands.end(),
                           [&](const ptx::Operand& operand) { return names(operand, shared); });
    };
    return any(instruction.operands) || any(instruction.arguments);
}

struct Uses {
    bool mayExchange = false;
    std::vector<std::string_view> callees;
};

Uses usesOf(const ptx::Function& function, Names shared) {
    addShared(function.variables, shared);
    Uses uses;
    for (const ptx::Statement& statement : function.body) {
        if (statement.kind != ptx::StatementKind::kInstruction)
            continue;
        const ptx::Instruction& instruction = statement.instruction;
        uses.mayExchange = uses.mayExchange || mayExchange(instruction, shared);
        if (instruction.target.kind == ptx::OperandKind::kSymbol)
            uses.callees.push_back(instruction.target.name);
    }
    return uses;
}

} // namespace

std::set<std::string_view>
functionsThatMayExchange(const std::vector<const ptx::Module*>& modules) {
    std::map<std::string_view, std::vector<std::string_view>> callers;
    Names found;
    std::vector<std::string_view> queue;
    for (const ptx::Module* module : modules) {
        Names shared;
        addShared(module->variables, shared);
        for (const ptx::Function& function : module->functions) {
            const Uses uses = usesOf(function, shared);
            for (const std::string_view callee : uses.callees)
                callers[callee].push_back(function.name);
            if (uses.mayExchange && found.insert(function.name).second)
                queue.push_back(function.name);
        }
    }
    while (!queue.empty()) {
        const std::string_view name = queue.back();
        queue.pop_back();
        for (const std::string_view caller : callers[name])
            if (found.insert(caller).second)
                queue.push_back(caller);
    }
    return found;
}

} // namespace sunstone::compiler
