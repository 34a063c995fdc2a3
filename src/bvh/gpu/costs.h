// SPDX-License-Identifier: Apache-2.0
// What a subtree of the binary tree costs rays, if it becomes up to 1, 2, .. 7 children of a wide
// node (Ylitie, Karras and Laine 2017, section 3.3): by surface areas, the step into a node counts
// 1 and a primitive 0.3. Costs are computed with each binary node, while it is made, and decide
// later which nodes are opened. The seven take one word: the first as 15 bits of a float, the
// others as shares of it.
#pragma once

#include "bvh/gpu/device.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kCosts = 7;

struct Costs {
    float of[kCosts]; // of[i]: as i + 1 children
};

SUNSTONE_BUILDER Costs unpackCosts(uint64_t word) {
    Costs c;
    c.of[0] = floatOf(uint32_t(word & 0x7FFFu) << 16);
    const float unit = mul(c.of[0], 1.0f / 255);
#pragma unroll
    for (uint32_t i = 1; i < kCosts; ++i)
        c.of[i] = mul(unit, float(uint32_t(word >> (7 + 8 * i)) & 0xFFu));
    return c;
}

SUNSTONE_BUILDER uint64_t packCosts(const Costs& c) {
    const uint32_t first = (bitsOf(c.of[0]) + 0x8000u) >> 16 & 0x7FFFu;
    uint64_t word = first;
    const float scale = first ? divide(255.0f, floatOf(first << 16)) : 0.0f;
#pragma unroll
    for (uint32_t i = 1; i < kCosts; ++i) {
        const float share = smaller(add(mul(c.of[i], scale), 0.5f), 255.0f);
        word |= uint64_t(uint32_t(share)) << (7 + 8 * i);
    }
    return word;
}

SUNSTONE_BUILDER uint64_t primitiveCosts(const BuildJob& job, float area) {
    Costs c;
    for (uint32_t i = 0; i < kCosts; ++i)
        c.of[i] = mul(area, job.primitiveCost);
    return packCosts(c);
}

// The cost of two subtrees as `slots` children together, and how many of them the left one gets.
SUNSTONE_BUILDER float shareSlots(const Costs& left, const Costs& right, uint32_t slots,
                                  uint32_t& ofLeft) {
    float best = __builtin_inff();
    ofLeft = 1;
#pragma unroll
    for (uint32_t k = 1; k <= kCosts; ++k)
#pragma unroll
        for (uint32_t m = 1; m <= kCosts; ++m)
            if (k + m == slots && add(left.of[k - 1], right.of[m - 1]) < best) {
                best = add(left.of[k - 1], right.of[m - 1]);
                ofLeft = k;
            }
    return best;
}

// Of a new node; count: of its primitives, 0 if too many for a leaf.
SUNSTONE_BUILDER uint64_t joinCosts(const BuildJob& job, float area, uint32_t count,
                                    uint64_t leftWord, uint64_t rightWord) {
    const Costs left = unpackCosts(leftWord), right = unpackCosts(rightWord);
    uint32_t unused;
    Costs c;
    c.of[0] = add(area, shareSlots(left, right, 8, unused));
    if (count)
        c.of[0] = smaller(c.of[0], mul(area, mul(job.primitiveCost, float(count))));
#pragma unroll
    for (uint32_t i = 1; i < kCosts; ++i)
        c.of[i] = smaller(c.of[i - 1], shareSlots(left, right, i + 1, unused));
    return packCosts(c);
}

} // namespace sunstone::bvh::gpu
