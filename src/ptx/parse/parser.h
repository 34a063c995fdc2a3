// SPDX-License-Identifier: Apache-2.0
// PTX text to tree. Never throws or crashes on bad text: faults go to `diagnostics`.
#pragma once

#include "ptx/ast.h"
#include "ptx/diagnostics.h"
#include "ptx/opcodes/opcode.h"

#include <functional>
#include <memory>
#include <string_view>

namespace sunstone::ptx {

// Decides whether an instruction that the table lacks is valid. The module has only that
// instruction, its symbols, the version and the target.
using Judge = std::function<bool(const Module& alone)>;

// Parses and verifies `text` (up to its first NUL). The result is null if and only if
// diagnostics.failed(). The message for OptiX-IR, ELF and other binary input names the format.
// Instructions that `judge` (may be empty) accepts are valid and marked as foreign. The module
// refers to rows of `opcodes`, which must outlive it.
std::unique_ptr<Module> parse(std::string_view text, Diagnostics& diagnostics,
                              const Judge& judge = {}, const OpcodeTable& opcodes = opcodeTable());

} // namespace sunstone::ptx
