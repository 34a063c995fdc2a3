// SPDX-License-Identifier: Apache-2.0
// Kernels whose lanes may exchange values through memory, found in the tree before any code is
// made. Kernels from before independent threads do so and count on the lanes of a warp to keep
// step. The optimised code decides (lockstep/steps.h); what is not found here needs no look at it.
#pragma once

#include "ptx/ast.h"

#include <set>
#include <string_view>
#include <vector>

namespace sunstone::compiler {

// Functions that access memory in one of these ways, themselves or through a function that they
// call by name: volatile accesses, where the access does not name local memory; atomic updates;
// variables in shared memory.
std::set<std::string_view> functionsThatMayExchange(const std::vector<const ptx::Module*>& modules);

} // namespace sunstone::compiler
