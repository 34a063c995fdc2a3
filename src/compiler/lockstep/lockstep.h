// SPDX-License-Identifier: Apache-2.0
// Kernels that run a warp at a time (devlib/lockstep.h).
//
// From the code of one thread, optimised, a function for 32 lanes is made. Each value of the
// program becomes a vector of 32, or stays one scalar where all lanes that run together have the
// same (lockstep/plan.cpp). Branches become masks: the blocks of the function follow one another in
// one order, each runs if any lane is at it, under the mask of those lanes, and hands their bits to
// the blocks they go on to; a loop repeats while any lane is at its head (lockstep/emit.cpp).
//
// Where threads meet, the function can be left and entered again: lanes leave their values in the
// frame of their warp and return; the launcher calls again with those that may go on. Warp
// functions whose lanes are all there are answered on the spot, without leaving. Lanes that read
// the same memory again and again leave as well, so that those they may wait for go on. That way no
// thread needs a stack of its own, and what threads may do apart from one another (warps that part,
// lanes that end early, barriers of some threads) is the launcher's business alone, as before.
//
// Kernels that cannot be written so keep only their code for one thread:
//  - meeting points in functions that are called through pointers or recursively;
//  - code for a debugger and for the memory checker.
// And where no threads meet, only those that gain by it have one (lockstep.cpp).
#pragma once

#include "compiler/compiler.h"
#include "compiler/machine.h"
#include "compiler/translate/unit.h"

namespace sunstone::compiler {

class Optimizer;

constexpr const char* kLockstepPrefix = "lockstep.";

// Before anything is optimised: lets functions with meeting points be inlined into their kernels.
void inlineMeetings(Unit& unit);

// After the kernel has been optimised: adds kLockstepPrefix + its name, if it can have one, and
// fills KernelInfo::lockstep. Logs the reason where it cannot (level debug).
void addLockstep(Unit& unit, Optimizer& optimizer, LentMachine& machine, llvm::Function& kernel,
                 KernelInfo& info);

} // namespace sunstone::compiler
