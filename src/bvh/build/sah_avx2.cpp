// SPDX-License-Identifier: Apache-2.0
#include "bvh/build/sah_builder.h"

#include "bvh/build/sah_builds.h"

namespace sunstone::bvh {

void buildSahTreeAvx2(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
                          const LeafRules& rules, Tree& tree) {
    avx2::SahBuilder(references, scratch, count, rules, tree).run();
}

} // namespace sunstone::bvh
