// SPDX-License-Identifier: Apache-2.0
// Puts bound values into the code: loads of launch parameters from places whose bytes are all bound
// become constants, and later passes propagate them. What cannot be seen to be such a load (the
// address is computed at run time or was handed on) keeps reading memory, which holds the same
// values if the client keeps its promise.
// Source: OptiX API reference 7.4, section 3.12.3.42.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// Works through all functions; gives the number of loads that took bytes of each value.
std::vector<uint32_t> substituteBoundValues(Unit& unit, const std::vector<BoundValue>& values);

} // namespace sunstone::compiler
