// SPDX-License-Identifier: Apache-2.0
// Replaces the `_optix_*` calls of a module by loads, stores and calls on RayState.
//
// There are two steps. inlineIntrinsicUsers inlines every function that reaches such a call into
// the calling programs, because ending a program (terminate, ignore, an accepted last hit) is a
// return of the program itself. After simplification, lowerIntrinsics replaces the calls. Operands
// that must be constants (payload slots, counts, types) are constants by then; otherwise the
// program is invalid.
#pragma once

#include "compiler/optix7/payload.h"
#include "compiler/translate/unit.h"

namespace sunstone::compiler {

using ProgramKinds = std::map<llvm::Function*, ProgramKind>;
using ProgramPayloads = std::map<llvm::Function*, const PayloadType*>;

// Metadata of loads, in code for GPUs, of what stays the same while a program runs. The memory serves
// the next launch index or ray then, so they are not invariant to LLVM.
constexpr const char* kStableLoad = "sunstone.stable";

// Marks for inlining; throws Error(kInvalidPtx) on recursion through such functions.
void markIntrinsicUsers(Unit& unit, const ProgramKinds& programs);

void lowerIntrinsics(Unit& unit, const ProgramKinds& programs, const ProgramPayloads& payloads);

} // namespace sunstone::compiler
