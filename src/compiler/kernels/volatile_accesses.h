// SPDX-License-Identifier: Apache-2.0
// Kernels that exchange values through volatile memory, found in the tree before any code is made.
// Kernels from before independent threads do so and count on the lanes of a warp to keep step.
#pragma once

#include "ptx/ast.h"

#include <set>
#include <string_view>
#include <vector>

namespace sunstone::compiler {

// The functions with a volatile access to memory, their own or that of a function they call by
// name. Local memory does not count where the access names its space.
std::set<std::string_view>
functionsWithVolatileAccesses(const std::vector<const ptx::Module*>& modules);

} // namespace sunstone::compiler
