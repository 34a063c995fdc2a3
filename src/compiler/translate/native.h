// SPDX-License-Identifier: Apache-2.0
// Which instructions stay inline PTX on a GPU, and what LLVM must know of them. The column `native`
// of the opcode's row decides, with the modifiers and types of the instruction.
#pragma once

#include "ptx/ast.h"

#include <optional>

namespace sunstone::compiler {

struct NativeForm {
    // The role of the first operand. kPerhaps: unknown, so its registers are both inputs and
    // outputs.
    enum Result : uint8_t { kNone, kFirst, kPerhaps } result = kFirst;
    bool effects = false;    // LLVM must not remove it
    bool convergent = false; // lanes of a warp execute it together
    bool memory = false;     // reads or writes memory
};

// Null for an instruction that becomes LLVM IR.
std::optional<NativeForm> nativeForm(const ptx::Instruction& instruction);

} // namespace sunstone::compiler
