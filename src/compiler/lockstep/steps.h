// SPDX-License-Identifier: Apache-2.0
// Kernels without warp functions whose results may still depend on lockstep.
#pragma once

#include <llvm/IR/Function.h>

namespace sunstone::compiler {

// Whether lanes exchange values through memory without meeting. On GPUs the lanes of a warp execute
// an access together, and programs rely on this: all lanes read a counter before one of them
// increments it; one lane clears a word before all lanes set bits of it. True for
//  - volatile accesses;
//  - loads and stores of shared memory, if the kernel has no barrier;
//  - atomic updates of memory that the kernel also accesses otherwise. Addresses from different
//    parameters count as different memory.
bool countsOnSteps(const llvm::Function& kernel, bool hasBarriers);

} // namespace sunstone::compiler
