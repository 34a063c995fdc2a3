// SPDX-License-Identifier: Apache-2.0
// Kernels whose lanes may exchange values through memory, found in the tree before any code is
// made. Kernels written before independent thread scheduling do so and rely on lockstep. The
// optimised code decides (lockstep/steps.h); kernels that are not found here need no optimised code
// for the decision.
#pragma once

#include "ptx/ast.h"

#include <set>
#include <string_view>
#include <vector>

namespace sunstone::compiler {

// Functions that, directly or through functions called by name, contain a volatile access (except
// to local memory by name), an atomic update, or a use of a variable in shared memory.
std::set<std::string_view> functionsThatMayExchange(const std::vector<const ptx::Module*>& modules);

} // namespace sunstone::compiler
