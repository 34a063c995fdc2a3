// SPDX-License-Identifier: Apache-2.0
// Kernels that run a warp at a time (devlib/lockstep.h).
//
// The compiler makes a function for 32 lanes from the optimised code of one thread. Each value of
// the program becomes a vector of 32, or stays a scalar if all lanes that run together have the
// same value (lockstep/plan.cpp). Branches become masks. The blocks of the function follow one
// another in one order. A block runs if any lane is at it, under the mask of those lanes, and
// passes their bits to the next blocks. A loop repeats while any lane is at its head
// (lockstep/emit.cpp).
//
// At a meeting point, lanes store their values in the frame of their warp and return. The launcher
// calls the function again with the lanes that may continue. A warp function whose lanes are all
// active is computed without a return. Lanes that keep reading the same memory also return, so that
// other lanes, for which they may wait, continue. No thread needs its own stack, and only the
// launcher handles threads that act separately (diverging warps, lanes that end early, barriers of
// some threads).
//
// Kernels have only the code for one thread if they are very long or have
//  - meeting points in functions that are called through pointers or recursively;
//  - code for a debugger (kernels that count on steps get the function all the same, see
//    kernels/compile_kernels.cpp) or for the memory checker.
// Kernels whose lanes do not exchange values get the function only if it is faster (lockstep.cpp).
// Long kernels get scalar code instead of vectors (lockstep/runs.cpp).
#pragma once

#include "compiler/compiler.h"
#include "compiler/machine.h"
#include "compiler/translate/unit.h"

namespace sunstone::compiler {

class Optimizer;

constexpr const char* kLockstepPrefix = "lockstep.";

// Whether all kernels are compiled as runs, as long kernels are (SUNSTONE_KERNELS=runs).
bool wantsRuns();

// Call before optimisation: allows inlining functions with meeting points into their kernels.
void inlineMeetings(Unit& unit);

// Call after the kernel has been optimised. Adds the function kLockstepPrefix + its name, if
// possible, and sets KernelInfo::hasLockstep; otherwise sets KernelInfo::singleReason.
void addLockstep(Unit& unit, Optimizer& optimizer, LentMachine& machine, llvm::Function& kernel,
                 KernelInfo& info);

} // namespace sunstone::compiler
