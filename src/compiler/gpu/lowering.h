// SPDX-License-Identifier: Apache-2.0
// Lowering that only code for GPUs needs, after the flavor has lowered the intrinsics.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// Intersection programs get the state of the traversal as a second parameter and pass it to their
// reports. If reports reached the traversal state through the ray's state, neither state could stay
// in registers. Replaces the intersection programs in `programs`.
void passCandidates(Unit& unit, std::vector<llvm::Function*>& programs);

// Lowers the remaining .ftz: adding -0 flushes and has no other effect.
void lowerFlushes(llvm::Module& module);

} // namespace sunstone::compiler
