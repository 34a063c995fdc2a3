// SPDX-License-Identifier: Apache-2.0
// Facts about each kernel from the call graph of its module: barriers, warp functions, local and
// shared memory. Also places the .shared variables.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// Of a kernel's parameters, of its local memory and of its static shared memory: sizes that are
// kept in 32 bits, and 32 lanes have 32 times as much. No GPU allows a hundredth.
constexpr uint64_t kMostKernelBytes = 64 << 20;
// Gives the kernel up if `bytes` of `what` are more.
void limitBytes(KernelInfo& kernel, uint64_t bytes, const char* what);

// `functions` and `kernels` have the same order; a null function is a kernel that was given up.
void describeThreads(Unit& unit, const std::vector<llvm::Function*>& functions,
                     std::vector<KernelInfo>& kernels);

} // namespace sunstone::compiler
