// SPDX-License-Identifier: Apache-2.0
// What the call graph of a kernel module says about each kernel: barriers, warp functions, local
// and shared memory. Places the .shared variables.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// `functions` and `kernels` go together; a null function is a kernel that was given up.
void describeThreads(Unit& unit, const std::vector<llvm::Function*>& functions,
                     std::vector<KernelInfo>& kernels);

} // namespace sunstone::compiler
