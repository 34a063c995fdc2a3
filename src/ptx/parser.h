// SPDX-License-Identifier: Apache-2.0
// PTX text to tree. Never throws on bad text and never crashes: faults go to `diagnostics`.
#pragma once

#include "ptx/ast.h"
#include "ptx/diagnostics.h"

#include <functional>
#include <memory>
#include <string_view>

namespace sunstone::ptx {

// Asked about instructions that the table does not know: whether they are right after all, by a
// module that has the instruction, what it names, the version and the target, and nothing else.
using Judge = std::function<bool(const Module& alone)>;

// Parses and verifies `text` (up to its first NUL). The result is null exactly when
// diagnostics.failed(). OptiX-IR, ELF and other binary input is named in the message. What `judge`
// (may be empty) accepts is no fault, and is marked as foreign.
std::unique_ptr<Module> parse(std::string_view text, Diagnostics& diagnostics,
                              const Judge& judge = {});

} // namespace sunstone::ptx
