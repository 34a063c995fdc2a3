// SPDX-License-Identifier: Apache-2.0
#include "bvh/build/tree.h"

#include "bvh/build/sah_builds.h"
#include "bvh/walk/kernels.h"

namespace sunstone::bvh {

// Both builders make leaves of at least minCount references (the root aside), so there are at most
// L = n / minCount of them. A node has eight children, or only leaves and at least two of these.
// With a nodes of leaves only and b others: edges = a + b - 1 + L >= 8 b + 2 a, so
// b <= (L - 1 - a) / 7, and a <= L / 2, hence a + b <= 4 L / 7.
uint32_t maxTreeNodes(uint64_t n, const LeafRules& rules) {
    return uint32_t(n / rules.minCount * 4 / 7 + 2);
}

// The largest number of nodes, leaves with the fewest references (2 to 4 per leaf: n / 2 leaves,
// which is more than with 5 to 8), and up to 32 bytes for alignment in each node.
uint64_t maxTreeBytes(uint64_t n, const LeafRules& rules) {
    const uint64_t leaves = n / rules.minCount + 1;
    const uint64_t padding = rules.bytes4 % 64 ? 32 : 0;
    return maxTreeNodes(n, rules) * (rules.nodeBytes + padding) + leaves * rules.bytes4 +
           (rules.maxCount > 4 ? rules.bytes8 : 0);
}

void buildSahTree(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
                  const LeafRules& rules, Tree& tree) {
    if (chosenIsa() >= Isa::kAvx2)
        buildSahTreeAvx2(references, scratch, count, rules, tree);
    else
        buildSahTreeBaseline(references, scratch, count, rules, tree);
}

} // namespace sunstone::bvh
