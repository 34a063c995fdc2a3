// SPDX-License-Identifier: Apache-2.0
// The SAH builder of each instruction set; tree.cpp chooses.
#pragma once

#include "bvh/build/tree.h"

namespace sunstone::bvh {

void buildSahTreeBaseline(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
                          const LeafRules& rules, Tree& tree);
void buildSahTreeAvx2(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
                      const LeafRules& rules, Tree& tree);

} // namespace sunstone::bvh
