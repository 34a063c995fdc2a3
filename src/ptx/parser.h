// SPDX-License-Identifier: Apache-2.0
// PTX text to tree. Never throws or crashes on bad text: faults go to `diagnostics`.
#pragma once

#include "ptx/ast.h"
#include "ptx/diagnostics.h"
#include "ptx/opcode.h"

#include <functional>
#include <memory>
#include <string_view>

namespace sunstone::ptx {

// Decides whether an instruction missing in the table is valid. The module it gets has only that
// instruction, the symbols it names, the version and the target.
using Judge = std::function<bool(const Module& alone)>;

// Parses and verifies `text` (up to its first NUL). The result is null exactly when
// diagnostics.failed(). The message for OptiX-IR, ELF and other binary input names the format.
// Instructions that `judge` (may be empty) accepts are valid, and are marked as foreign. The module
// refers to rows of `opcodes`.
std::unique_ptr<Module> parse(std::string_view text, Diagnostics& diagnostics,
                              const Judge& judge = {}, const OpcodeTable& opcodes = opcodeTable());

} // namespace sunstone::ptx
