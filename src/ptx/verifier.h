// SPDX-License-Identifier: Apache-2.0
// Checks of a module's instructions: opcodes and modifiers that exist, operand counts, widths,
// callees that exist. The rules are the table in instructions.h.
#pragma once

#include "ptx/ast.h"
#include "ptx/parser.h"

namespace sunstone::ptx {

// Marks instructions that only `judge` (may be empty) knows.
void verify(Module& module, Diagnostics& diagnostics, const Judge& judge = {});

} // namespace sunstone::ptx
