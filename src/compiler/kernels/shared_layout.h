// SPDX-License-Identifier: Apache-2.0
// Facts about each kernel from the call graph of its module: barriers, warp functions, local and
// shared memory. Also places the .shared variables.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// The limit for each of a kernel's parameters, local memory and static shared memory. These sizes,
// and 32 times the size for 32 lanes, must fit into 32 bits. No GPU allows a hundredth of the
// limit.
constexpr uint64_t kMostKernelBytes = 64 << 20;
// Marks the kernel as unsupported if `bytes` of `what` exceed the limit.
void limitBytes(KernelInfo& kernel, uint64_t bytes, const char* what);

// `functions` and `kernels` have the same order; a null function is an unsupported kernel.
void describeThreads(Unit& unit, const std::vector<llvm::Function*>& functions,
                     std::vector<KernelInfo>& kernels);

} // namespace sunstone::compiler
