// SPDX-License-Identifier: Apache-2.0
// The states of a lane's rays in the kernel of devlib/gpu/nested.h are an array, indexed by depth,
// and so stay in memory as a whole, word for word written and read. Here each field is looked at
// for all depths together: where every ray is given the same value (the launch, a mask, a stride)
// that value takes the place of loads, and what nobody loads is not stored.
#pragma once

#include <llvm/IR/Instructions.h>

namespace sunstone::compiler {

// `states`: an array of RayState in a kernel that has been optimised. Nothing is changed if its
// addresses go anywhere else. Returns whether something was.
bool foldRayStates(llvm::AllocaInst& states);

} // namespace sunstone::compiler
