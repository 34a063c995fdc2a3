// SPDX-License-Identifier: Apache-2.0
// See volatile_accesses.h.
#include "compiler/kernels/volatile_accesses.h"

#include <map>

namespace sunstone::compiler {

namespace {

struct Uses {
    bool hasVolatile = false;
    std::vector<std::string_view> callees;
};

Uses usesOf(const ptx::Function& function) {
    Uses uses;
    for (const ptx::Statement& statement : function.body) {
        if (statement.kind != ptx::StatementKind::kInstruction)
            continue;
        const ptx::Instruction& instruction = statement.instruction;
        uses.hasVolatile |= instruction.has("volatile") && !instruction.has("local");
        if (instruction.target.kind == ptx::OperandKind::kSymbol)
            uses.callees.push_back(instruction.target.name);
    }
    return uses;
}

} // namespace

std::set<std::string_view>
functionsWithVolatileAccesses(const std::vector<const ptx::Module*>& modules) {
    std::map<std::string_view, std::vector<std::string_view>> callers;
    std::set<std::string_view> found;
    std::vector<std::string_view> queue;
    for (const ptx::Module* module : modules)
        for (const ptx::Function& function : module->functions) {
            const Uses uses = usesOf(function);
            for (const std::string_view callee : uses.callees)
                callers[callee].push_back(function.name);
            if (uses.hasVolatile && found.insert(function.name).second)
                queue.push_back(function.name);
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
