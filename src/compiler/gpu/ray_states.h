// SPDX-License-Identifier: Apache-2.0
// The states of a lane's rays in the kernel of devlib/gpu/nested.h are an array, indexed by depth,
// so LLVM keeps it in memory as a whole. This pass considers each field for all depths together: if
// every ray gets the same value (the launch, a mask, a stride), the value replaces the loads, and
// stores that no load reads are removed.
#pragma once

#include <llvm/IR/Instructions.h>

namespace sunstone::compiler {

// `states`: an array of RayState in an optimised kernel. Changes nothing if the array's addresses
// have other uses. Returns whether it changed the kernel.
bool foldRayStates(llvm::AllocaInst& states);

} // namespace sunstone::compiler
