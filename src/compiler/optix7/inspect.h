// SPDX-License-Identifier: Apache-2.0
// What calls of a module alone say about it; see also inspect in compiler.h.
#pragma once

#include "compiler/compiler.h"

namespace sunstone::compiler {

// Payload types that a host could give the module: as many as its calls name, each with the words
// that its traces pass, and all programs may access all words. Empty: the module names none.
std::vector<PayloadType> widestPayloadTypes(const ptx::Module& module);

} // namespace sunstone::compiler
