// SPDX-License-Identifier: Apache-2.0
// Rays and the boxes of nodes.
//
// The triangle test accepts a ray as if vertices were displaced by up to 5 * 2^-24 times their
// distance from the ray's origin (bvh/walk/ray_setup.h). Node tests therefore move the planes
// outwards by 2^-20 of the distance of the node's farthest corner, which also covers the rounding
// here. A component of the direction below 2^-24 of the longest component is replaced by that
// length, which moves the ray by less. Bytes become floats without a conversion: they are bits 8 to
// 15 of 1 + q * 2^-15. The constant subtracts the 1, which costs 2^-8 of a grid step; the margin
// includes this.
#pragma once

#include "bvh/gpu/layout.h"
#include "bvh/gpu/portable.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

// A ray in the current space; tmin and tmax are equal in all spaces.
struct Ray {
    float origin[3], tmin;
    float direction[3], tmax;
};

// The data of a ray in a space that box tests need.
struct BoxRay {
    float inverse[3];
    float slack; // margin of the planes, relative to the node's distance
    // Slots are visited in the order of rankOf(slot), highest first. Each byte has bits for the
    // side that the ray leaves last; ranksOf() describes the bits from 30 on.
    uint32_t octant;
    // 1, hidden from the compiler, because the byte permutation takes only one constant, which
    // should be the selector.
    float one;
};

// A slot's bits are its sides of the node, the highest along z. Its rank is slot ^ octant, rotated
// so that the side along the ray's longest axis comes first, because the other sides are less
// correlated with the distance of a child. Four slots at a time, one in the low bits of each byte;
// their other bits are undefined.
SUNSTONE_INLINE uint32_t ranksOf(uint32_t octant, uint32_t slots) {
    return ((slots ^ octant) & 0x07070707u) * 9 >> (octant >> 30);
}
SUNSTONE_INLINE uint32_t rankOf(uint32_t octant, uint32_t slot) {
    return ranksOf(octant, slot) & 7u;
}
SUNSTONE_INLINE uint32_t slotOf(uint32_t octant, uint32_t rank) {
    return (rank * 9 >> (3 - (octant >> 30)) ^ octant) & 7u;
}

SUNSTONE_INLINE bool isRay(const Ray& r) {
    const float sum = magnitude(r.origin[0]) + magnitude(r.origin[1]) + magnitude(r.origin[2]) +
                      magnitude(r.direction[0]) + magnitude(r.direction[1]) +
                      magnitude(r.direction[2]) + magnitude(r.tmin);
    const float longest = larger(larger(magnitude(r.direction[0]), magnitude(r.direction[1])),
                                 magnitude(r.direction[2]));
    return (bitsOf(sum) & 0x7F800000u) != 0x7F800000u && r.tmin <= r.tmax && longest >= 0x1p-120f;
}

// `size`: the largest coordinate in the structure.
SUNSTONE_INLINE BoxRay makeBoxRay(const float d[3], float size) {
    BoxRay box;
    const float longest = larger(larger(magnitude(d[0]), magnitude(d[1])), magnitude(d[2]));
    const float least = mul(longest, 0x1p-24f);
    // Outside these ranges, reciprocals are not normal numbers, or constants of nodes (up to 2^39
    // times the size) are not finite; every box then counts as hit.
    const bool usual = longest >= 0x1p-100f && longest <= 0x1p100f && size <= mul(longest, 0x1p85f);
    box.slack = usual ? 0x1p-20f : 0x1p127f;
    uint32_t order = 0;
    for (int i = 0; i < 3; ++i) {
        const float speed = larger(magnitude(d[i]), least);
        const float inverse = usual ? roughReciprocal(speed) : 1.0f;
        const bool down = bitsOf(d[i]) >> 31;
        box.inverse[i] = down ? -inverse : inverse;
        order |= (down ? 0u : 1u) << i;
    }
    const uint32_t axis = magnitude(d[2]) == longest ? 2 : (magnitude(d[1]) == longest ? 1 : 0);
    box.octant = order * 0x01010101u | (axis + 1) << 30;
    box.one = fused(box.inverse[0], 0.0f, 1.0f);
    return box;
}

// Children or primitives to visit. Inner: bits 24 to 31 are the hit children, by rank, bits 0 to 7
// the slots that are nodes. Primitives: bits 0 to 23.
struct Group {
    uint32_t base, bits;
};

// The bits that four children of a node add to a Group where they are hit.
struct Slots {
    uint32_t place, bits;

    SUNSTONE_INLINE_MEMBER Slots(uint32_t meta, uint32_t octant) {
        // Inner children have both bits of 24.
        const uint32_t isInner = (meta & (meta << 1)) & 0x10101010u;
        const uint32_t slotBits = (isInner >> 4) * 7u;
        place = (meta & ~slotBits) | (ranksOf(octant, meta) & slotBits);
        bits = meta >> 5 & 0x07070707u;
    }
    SUNSTONE_INLINE_MEMBER uint32_t hit(uint32_t k) const {
        return shiftLeft(permute(bits, 0, 0x4440u | k), place >> 8 * k);
    }
};

SUNSTONE_INLINE void setGroups(U4 head, U4 children, uint32_t hits, Group& inner, Group& leaf) {
    inner.base = children.x;
    inner.bits = (hits & 0xFF000000u) | head.w >> 24;
    leaf.base = children.y;
    leaf.bits = hits & 0x00FFFFFFu;
}

SUNSTONE_INLINE int32_t orderedInt(float a) {
    return __builtin_bit_cast(int32_t, a);
}

// Entry distances of the hit children of a node: the bits of a non-negative distance, rounded down,
// and the slot. The metas are those of the node.
template <bool kWanted>
struct Distances {
    uint32_t keys[8];
    uint32_t metas[2];

    SUNSTONE_INLINE_MEMBER void set(uint32_t slot, bool hit, int32_t begin) {
        keys[slot] = hit ? (uint32_t(begin) & ~7u) | slot : kMissed;
    }
    SUNSTONE_INLINE_MEMBER void order(uint32_t i, uint32_t k) {
        const uint32_t a = keys[i], b = keys[k];
        keys[i] = a < b ? a : b;
        keys[k] = a < b ? b : a;
    }
    // Nearest first (Batcher's network).
    SUNSTONE_INLINE_MEMBER void sort() {
        order(0, 1), order(2, 3), order(4, 5), order(6, 7);
        order(0, 2), order(1, 3), order(4, 6), order(5, 7);
        order(1, 2), order(5, 6);
        order(0, 4), order(1, 5), order(2, 6), order(3, 7);
        order(2, 4), order(3, 5);
        order(1, 2), order(3, 4), order(5, 6);
    }
    static constexpr uint32_t kMissed = ~0u;
};
template <>
struct Distances<false> {
    uint32_t metas[2];
    SUNSTONE_INLINE_MEMBER void set(uint32_t, bool, int32_t) {}
};

// Tests the boxes of a node's children. tmin must not be negative.
template <bool kDistances>
SUNSTONE_INLINE void testNode(const U4* node, const float origin[3], const BoxRay& ray, float tmin,
                              float tmax, Group& inner, Group& leaf,
                              Distances<kDistances>& distances) {
    const U4 head = loadConstant(node), children = loadConstant(node + 1);
    const U4 planes0 = loadConstant(node + 2), planes1 = loadConstant(node + 3),
             planes2 = loadConstant(node + 4);
    const float step[3] = {floatOf((head.w & 0xFFu) << 23), floatOf((head.w & 0xFF00u) << 15),
                           floatOf((head.w & 0xFF0000u) << 7)};
    const float from[3] = {sub(floatOf(head.x), origin[0]), sub(floatOf(head.y), origin[1]),
                           sub(floatOf(head.z), origin[2])};
    const float reach = larger(larger(fused(255.0f, step[0], magnitude(from[0])),
                                      fused(255.0f, step[1], magnitude(from[1]))),
                               fused(255.0f, step[2], magnitude(from[2])));
    const float slack = reach * ray.slack;
    float scale[3], nearC[3], farC[3];
    for (int i = 0; i < 3; ++i) {
        const float s = mul(step[i], ray.inverse[i]);
        const float margin = fused(magnitude(s), 0x1p-8f, mul(magnitude(ray.inverse[i]), slack));
        scale[i] = mul(s, 0x1p15f);
        const float middle = fused(from[i], ray.inverse[i], -scale[i]);
        nearC[i] = sub(middle, margin);
        farC[i] = add(middle, margin);
    }
    // Lower planes: planes0.xy, .zw, planes1.xy; upper: planes1.zw, planes2.xy, .zw.
    const uint32_t one = bitsOf(ray.one);
    const bool downX = ray.inverse[0] < 0, downY = ray.inverse[1] < 0, downZ = ray.inverse[2] < 0;
    uint32_t hits = 0;
#pragma unroll
    for (int half = 0; half < 2; ++half) {
        const uint32_t lowX = half ? planes0.y : planes0.x, highX = half ? planes1.w : planes1.z;
        const uint32_t lowY = half ? planes0.w : planes0.z, highY = half ? planes2.y : planes2.x;
        const uint32_t lowZ = half ? planes1.y : planes1.x, highZ = half ? planes2.w : planes2.z;
        const uint32_t nearX = downX ? highX : lowX, farX = downX ? lowX : highX;
        const uint32_t nearY = downY ? highY : lowY, farY = downY ? lowY : highY;
        const uint32_t nearZ = downZ ? highZ : lowZ, farZ = downZ ? lowZ : highZ;
        const Slots slots(half ? children.w : children.z, ray.octant);
#pragma unroll
        for (uint32_t k = 0; k < 4; ++k) {
            const uint32_t selector = 0x7604u | k << 4;
            const auto plane = [&](uint32_t bytes, float s, float c) {
                return orderedInt(fused(floatOf(permute(bytes, one, selector)), s, c));
            };
            const auto most = [](int32_t a, int32_t b) { return a > b ? a : b; };
            const auto least = [](int32_t a, int32_t b) { return a < b ? a : b; };
            // Compared as integers, which is correct if one operand, here tmin, is not negative.
            const int32_t begin =
                most(most(plane(nearX, scale[0], nearC[0]), plane(nearY, scale[1], nearC[1])),
                     most(plane(nearZ, scale[2], nearC[2]), orderedInt(tmin)));
            const int32_t end =
                least(least(plane(farX, scale[0], farC[0]), plane(farY, scale[1], farC[1])),
                      least(plane(farZ, scale[2], farC[2]), orderedInt(tmax)));
            if (begin <= end)
                hits |= slots.hit(k);
            distances.set(4 * uint32_t(half) + k, begin <= end, begin);
        }
    }
    distances.metas[0] = children.z;
    distances.metas[1] = children.w;
    setGroups(head, children, hits, inner, leaf);
}

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
