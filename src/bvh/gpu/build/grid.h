// SPDX-License-Identifier: Apache-2.0
// The grid of a wide node: the planes of its children's boxes as bytes, and its meta bytes
// (layout.h).
#pragma once

#include "bvh/gpu/device.h"

namespace sunstone::bvh::gpu {

constexpr uint32_t kSlots = 8;

// The space that a node's grid spans; also valid for an empty node.
SUNSTONE_INLINE Bounds gridOf(const Bounds& whole) {
    return isEmpty(whole) ? Bounds{} : whole;
}

// Called by eight consecutive lanes; all lanes of the warp take part.
SUNSTONE_INLINE Bounds uniteOfEight(Bounds box) {
    for (uint32_t step = 1; step < kSlots; step *= 2) {
        Bounds other;
        for (int a = 0; a < 3; ++a) {
            other.lower[a] = __shfl_xor_sync(kWholeWarp, box.lower[a], int(step));
            other.upper[a] = __shfl_xor_sync(kWholeWarp, box.upper[a], int(step));
        }
        box = unite(box, other);
    }
    return box;
}

// The step of an axis: a power of two such that 255 steps span the node with a margin for rounding.
SUNSTONE_INLINE uint32_t stepExponent(float size) {
    uint32_t exponent = bitsOf(mul(size, 1.0f / 254.9375f)) >> 23;
    exponent += 1; // up to the next power of two, or one further
    return exponent < 254 ? exponent : 254;
}
// The reciprocal of a power of two; steps below 2^-126 do not occur.
SUNSTONE_INLINE float inverseStep(uint32_t exponent) {
    return floatOf((254u - exponent) << 23);
}

// Round planes outwards. An empty box has crossed planes: 255 and 0.
SUNSTONE_INLINE uint32_t lowerByte(float plane, float origin, float inverse) {
    const float low = mul(sub(plane, origin), inverse);
    // The rounding above is below 2^-15 of a step.
    return uint32_t(smaller(larger(__builtin_floorf(sub(low, 0x1p-14f)), 0.0f), 255.0f));
}
SUNSTONE_INLINE uint32_t upperByte(float plane, float origin, float inverse) {
    const float high = mul(sub(plane, origin), inverse);
    return uint32_t(larger(smaller(__builtin_ceilf(add(high, 0x1p-14f)), 255.0f), 0.0f));
}

// Meta byte of a leaf of up to three primitives, from place `first` among the node's primitives.
// Rays must never enter a leaf with a single inactive primitive.
SUNSTONE_INLINE uint32_t leafMeta(uint32_t count, uint32_t first, bool inactive) {
    return inactive ? first + 1 : ((1u << count) - 1) << 5 | first;
}
// Decodes a leaf's meta byte. count: 0 if the slot is unused.
struct LeafRun {
    uint32_t first, count;
};
SUNSTONE_INLINE LeafRun leafRun(uint32_t meta) {
    if (meta == 0)
        return {0, 0};
    if (meta >> 5 == 0)
        return {meta - 1, 1};
    return {meta & 31u, uint32_t(__popc(meta >> 5))};
}

} // namespace sunstone::bvh::gpu
