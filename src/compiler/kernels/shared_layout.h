// SPDX-License-Identifier: Apache-2.0
// Facts about each kernel from the call graph of its module: barriers, warp functions, local and
// shared memory. Also places the .shared variables.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// `functions` and `kernels` have the same order; a null function is a kernel that was given up.
void describeThreads(Unit& unit, const std::vector<llvm::Function*>& functions,
                     std::vector<KernelInfo>& kernels);

} // namespace sunstone::compiler
