// SPDX-License-Identifier: Apache-2.0
// Checks a module's instructions: known opcodes and modifiers, operand counts, widths, and existing
// callees. The rules are the forms of each opcode (opcodes/opcode.h).
#pragma once

#include "ptx/ast.h"
#include "ptx/parse/parser.h"

namespace sunstone::ptx {

// Instructions that only `judge` (may be empty) accepts are marked as foreign. Messages about
// unknown opcodes propose one of `opcodes`.
void verify(Module& module, Diagnostics& diagnostics, const Judge& judge,
            const OpcodeTable& opcodes);

} // namespace sunstone::ptx
