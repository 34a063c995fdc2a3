// SPDX-License-Identifier: Apache-2.0
// Checks of a module's instructions: opcodes and modifiers that exist, operand counts, widths,
// callees that exist. The rules are the table in instructions.h.
#pragma once

#include "ptx/ast.h"
#include "ptx/diagnostics.h"

namespace sunstone::ptx {

void verify(const Module& module, Diagnostics& diagnostics);

} // namespace sunstone::ptx
