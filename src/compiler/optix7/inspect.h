// SPDX-License-Identifier: Apache-2.0
// Facts about a module that follow from its calls; see also inspect in compiler.h.
#pragma once

#include "compiler/compiler.h"

namespace sunstone::compiler {

// Payload types that a host could give the module: one for each type in its calls, with the words
// that its traces pass, and with all access rights. Empty if the calls use no types.
std::vector<PayloadType> widestPayloadTypes(const ptx::Module& module);

} // namespace sunstone::compiler
