// SPDX-License-Identifier: Apache-2.0
// Operands of a function that are known numbers, found in the tree before code generation.
#pragma once

#include "ptx/ast.h"

#include <cstdint>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

namespace sunstone::compiler {

// Follows a register to its only definition: a number, a copy, or a load of a value that the
// function has stored before (without optimisation, compilers keep arguments in memory).
class TreeConstants {
public:
    explicit TreeConstants(const ptx::Function& function);

    std::optional<uint32_t> valueOf(const ptx::Operand& operand) const;

private:
    void define(const ptx::Operand& target, size_t statement);
    const ptx::Instruction* definitionOf(const ptx::Operand& operand) const;
    const ptx::Operand* storedBefore(size_t load) const;

    const ptx::Function& function_;
    std::set<uint32_t> targets_;        // labels that jumps name; others are for debuggers
    std::vector<unsigned> definitions_; // by register
    std::unordered_map<uint32_t, size_t> statements_; // with a register's last definition
};

} // namespace sunstone::compiler
