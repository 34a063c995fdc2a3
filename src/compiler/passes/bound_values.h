// SPDX-License-Identifier: Apache-2.0
// Replaces loads of launch parameters whose bytes are all bound by constants, which later passes
// propagate. Other loads (with addresses computed at run time or passed to functions) read memory,
// which holds the same values if the application keeps the API's contract. Source: OptiX API
// reference 7.4, section 3.12.3.42.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// Processes all functions; returns, for each value, the number of loads that used its bytes.
std::vector<uint32_t> substituteBoundValues(Unit& unit, const std::vector<BoundValue>& values);

} // namespace sunstone::compiler
