// SPDX-License-Identifier: Apache-2.0
// PTX text to tree. Never throws on bad text and never crashes: faults go to `diagnostics`.
#pragma once

#include "ptx/ast.h"
#include "ptx/diagnostics.h"

#include <memory>
#include <string_view>

namespace sunstone::ptx {

// Parses and verifies `text` (up to its first NUL). The result is null exactly when
// diagnostics.failed(). OptiX-IR, ELF and other binary input is named in the message.
std::unique_ptr<Module> parse(std::string_view text, Diagnostics& diagnostics);

} // namespace sunstone::ptx
