// SPDX-License-Identifier: Apache-2.0
// The savings for rays from opening a node of the binary tree into up to 2, 3, .. 7 children of a
// wide node (after Ylitie, Karras and Laine 2017, section 3.3). Costs are surface areas; the step
// into a node counts 1 and a primitive 0.3. Savings are computed as each binary node is made, and
// later decide which nodes are opened.
//
// Absolute costs are not needed: terms common to both sides of a choice cancel. High in the tree
// these terms are so large that rounding would decide the choice. Savings are at most the areas of
// the opened nodes, fewer than seven times that of the first; a word holds six of ten bits each, in
// 128ths of the node's area.
#pragma once

#include "bvh/gpu/device.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kMostChildren = 7; // of a node that is not the wide node itself

struct Savings {
    float of[kMostChildren]; // of[i]: as up to i + 1 children; of[0] is 0
};

// A node, or a primitive: its number of primitives (0: too many to store), the area of its box, and
// its savings packed.
struct CostPart {
    uint32_t count;
    float area;
    uint64_t savings;
};

SUNSTONE_INLINE Savings unpackSavings(const CostPart& part) {
    Savings s;
    s.of[0] = 0;
    const float unit = mul(part.area, 1.0f / 128);
#pragma unroll
    for (uint32_t i = 1; i < kMostChildren; ++i)
        s.of[i] = mul(unit, float(uint32_t(part.savings >> 10 * (i - 1)) & 1023u));
    return s;
}

SUNSTONE_INLINE uint64_t packSavings(const Savings& s, float area) {
    const float scale = area > 0 ? divide(128.0f, area) : 0.0f;
    uint64_t word = 0;
#pragma unroll
    for (uint32_t i = 1; i < kMostChildren; ++i) {
        const float units = smaller(add(mul(s.of[i], scale), 0.5f), 1023.0f);
        word |= uint64_t(uint32_t(units)) << 10 * (i - 1);
    }
    return word;
}

// The savings of two parts as `slots` children together, and the left part's share of the slots.
SUNSTONE_INLINE float shareSlots(const Savings& left, const Savings& right, uint32_t slots,
                                 uint32_t& ofLeft) {
    float best = -1;
    ofLeft = 1;
#pragma unroll
    for (uint32_t k = 1; k <= kMostChildren; ++k)
#pragma unroll
        for (uint32_t m = 1; m <= kMostChildren; ++m)
            if (k + m == slots && add(left.of[k - 1], right.of[m - 1]) > best) {
                best = add(left.of[k - 1], right.of[m - 1]);
                ofLeft = k;
            }
    return best;
}

// The same for a number of slots that is not a constant: reads the right part's savings from the
// packed word.
SUNSTONE_INLINE float shareAnySlots(const Savings& left, const CostPart& right, uint32_t slots,
                                    uint32_t& ofLeft) {
    const float unit = mul(right.area, 1.0f / 128);
    float best = -1;
    ofLeft = 1;
#pragma unroll
    for (uint32_t k = 1; k <= kMostChildren; ++k) {
        const uint32_t m = slots - k; // slots: at most one more than kMostChildren
        const float saved =
            m > 1 ? mul(unit, float(uint32_t(right.savings >> 10 * (m - 2) % 64) & 1023u)) : 0.0f;
        const float sum = add(left.of[k - 1], saved);
        if (k < slots && sum > best) {
            best = sum;
            ofLeft = k;
        }
    }
    return best;
}

// The cost of a node of this area as one child (a leaf if possible, else a wide node), minus the
// cost of its two parts as a child each.
SUNSTONE_INLINE float excessOf(const BuildJob& job, float area, bool mayBeLeaf,
                               const CostPart& left, const CostPart& right,
                               const Savings& leftSavings, const Savings& rightSavings) {
    uint32_t unused;
    const float asNode =
        sub(area, shareSlots(leftSavings, rightSavings, kMostChildren + 1, unused));
    if (!mayBeLeaf)
        return asNode;
    const float tests = mul(area, float(left.count + right.count)),
                apart = add(mul(left.area, float(left.count)), mul(right.area, float(right.count)));
    return smaller(asNode, mul(job.primitiveCost, sub(tests, apart)));
}

// The packed savings of a new node.
SUNSTONE_INLINE uint64_t joinSavings(const BuildJob& job, float area, bool mayBeLeaf,
                                     const CostPart& left, const CostPart& right) {
    const Savings l = unpackSavings(left), r = unpackSavings(right);
    const float excess = excessOf(job, area, mayBeLeaf, left, right, l, r);
    Savings s;
    s.of[0] = 0;
    uint32_t unused;
#pragma unroll
    for (uint32_t i = 1; i < kMostChildren; ++i)
        s.of[i] = larger(s.of[i - 1], add(excess, shareSlots(l, r, i + 1, unused)));
    return packSavings(s, area);
}

} // namespace sunstone::bvh::gpu
