// SPDX-License-Identifier: Apache-2.0
// Lowering that only the code for GPUs needs; the flavor has lowered the intrinsics before.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// Intersection programs get the state of the traversal as a second parameter and pass it to their
// reports. Passed through the ray's state, which it refers to, neither could stay in registers.
// Replaces those functions among `programs`.
void passCandidates(Unit& unit, std::vector<llvm::Function*>& programs);

// Lowers the remaining .ftz: adding -0 flushes and has no other effect.
void lowerFlushes(llvm::Module& module);

} // namespace sunstone::compiler
