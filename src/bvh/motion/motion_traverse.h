// SPDX-License-Identifier: Apache-2.0
// Traversal of structures with motion keys: the loop of traverse.h with nodes and triangles
// interpolated at the ray's time. Compiled once per instruction set, like traverse.h.
//
// A plane at the time is a * (1 - f) + b * f, and its distance is the plane times r plus c
// (ray_setup.h). With FMA both together take two multiply-adds, a * ((1 - f) r) + (b * (f r) + c),
// as many as the interpolation alone. The rounding of these operations and of interpolated vertices
// is below (2^-22 M + 2^-24 |origin|) r, where M is the largest coordinate in the structure; the
// constants include twice that as a margin. Without FMA, planes are interpolated by the operations
// of the vertices, which are monotone, and need no margin.
#pragma once

#include "bvh/motion/motion.h"
#include "bvh/walk/triangle_visitors.h"

namespace sunstone::bvh::SUNSTONE_ISA {

// The largest magnitude of a coordinate in the structure, at any time.
SUNSTONE_INLINE float largestCoordinate(const BlockHeader& header) {
    float most = 0;
    for (int i = 0; i < 3; ++i)
        most = larger(most, larger(absolute(header.lower[i]), absolute(header.upper[i])));
    return most * (1 + 0x1p-18f); // boxes are padded
}

// Tests nodes at one time; see traverse.h.
struct MovingNodes {
    F8 nearA[3], nearB[3], nearC[3], farA[3], farB[3], farC[3], org[3], tmin;
    uint32_t nearOffset[3], farOffset[3]; // of the planes at the first key, in a node
    uint32_t step;                        // from there to the second key

    SUNSTONE_INLINE_MEMBER MovingNodes(const BlockHeader& header, const RaySetup& s, KeySegment at)
        : tmin(splat(larger(s.tmin, 0.0f), (F8*)nullptr)) {
        F8* const f = nullptr;
        const float g = 1.0f - at.fraction;
        const float most = largestCoordinate(header);
        const uint32_t base =
            at.key == 0 ? 0 : uint32_t(sizeof(Node) + (at.key - 1) * sizeof(KeyPlanes));
        step = at.key == 0 ? uint32_t(sizeof(Node)) : uint32_t(sizeof(KeyPlanes));
        for (int i = 0; i < 3; ++i) {
            nearOffset[i] = base + s.nearPlanes[i];
            farOffset[i] = base + s.farPlanes(i);
            org[i] = splat(s.org[i], f);
            if constexpr (kFusedSlab) {
                const float r = larger(absolute(s.nearR[i]), absolute(s.farR[i]));
                const float margin = (most * 0x1p-21f + absolute(s.org[i]) * 0x1p-23f) * r;
                nearA[i] = splat(s.nearR[i] * g, f);
                nearB[i] = splat(s.nearR[i] * at.fraction, f);
                nearC[i] = splat(s.nearC[i] - margin, f);
                farA[i] = splat(s.farR[i] * g, f);
                farB[i] = splat(s.farR[i] * at.fraction, f);
                farC[i] = splat(s.farC[i] + margin, f);
            } else {
                nearA[i] = splat(g, f);
                nearB[i] = splat(at.fraction, f);
                nearC[i] = splat(s.nearC[i], f);
                farA[i] = splat(s.nearR[i], f); // without FMA: the speeds
                farB[i] = splat(s.farR[i], f);
                farC[i] = splat(s.farC[i], f);
            }
        }
    }

    SUNSTONE_INLINE_MEMBER const MovingNodes& reloaded() const { return *this; }

    SUNSTONE_INLINE_MEMBER Mask test(const uint8_t* node, float tmax, F8& distance) const {
        F8* const f = nullptr;
        const auto near = [&](int i) {
            const auto* at = reinterpret_cast<const float*>(node + nearOffset[i]);
            const auto* next = reinterpret_cast<const float*>(node + nearOffset[i] + step);
            return distanceTo(load(at, f), load(next, f), i, nearA[i], nearB[i], nearC[i], farA[i]);
        };
        const auto far = [&](int i) {
            const auto* at = reinterpret_cast<const float*>(node + farOffset[i]);
            const auto* next = reinterpret_cast<const float*>(node + farOffset[i] + step);
            if constexpr (kFusedSlab)
                return distanceTo(load(at, f), load(next, f), i, farA[i], farB[i], farC[i],
                                  farA[i]);
            else
                return distanceTo(load(at, f), load(next, f), i, nearA[i], nearB[i], farC[i],
                                  farB[i]);
        };
        distance = max(max(near(0), near(1)), max(near(2), tmin));
        const F8 end = min(min(far(0), far(1)), min(far(2), splat(tmax, f)));
        return lessEqual(distance, end);
    }

    SUNSTONE_INLINE_MEMBER void prefetch(const uint8_t* block, uint64_t offset) const {
        prefetchNode(block, offset);
        const uint8_t* const second = block + offset + (nearOffset[0] & ~63u) + step;
        for (uint32_t i = 0; i < 3; ++i)
            __builtin_prefetch(second + 64 * i);
    }

private:
    SUNSTONE_INLINE_MEMBER F8 distanceTo(F8 a, F8 b, [[maybe_unused]] int axis, F8 weightA,
                                         F8 weightB, F8 c, [[maybe_unused]] F8 r) const {
        if constexpr (kFusedSlab)
            return fusedMultiplyAdd(a, weightA, fusedMultiplyAdd(b, weightB, c));
        else
            return slab(a * weightA + b * weightB, org[axis], r, c);
    }
};

// A leaf of triangles at a time.
template <unsigned N, class F>
struct MovingLeaf {
    const float *first, *second; // vertices at the two keys
    F weightFirst, weightSecond;
    const uint32_t *primitive, *sbt;
};

template <unsigned N, class F>
SUNSTONE_INLINE F vertexLanes(const MovingLeaf<N, F>& leaf, uint32_t vertex, uint32_t axis, F* f) {
    const uint32_t at = (3 * vertex + axis) * N;
    return load(leaf.first + at, f) * leaf.weightFirst +
           load(leaf.second + at, f) * leaf.weightSecond;
}

template <unsigned N, class F>
SUNSTONE_INLINE MovingLeaf<N, F> leafAt(const void* address, KeySegment at) {
    F* const f = nullptr;
    const auto& leaf = *static_cast<const TriangleLeaf<N>*>(address);
    const float* const later = reinterpret_cast<const float*>(&leaf + 1);
    return {at.key == 0 ? leaf.vertices : later + (at.key - 1) * 9 * N,
            later + at.key * 9 * N,
            splat(1.0f - at.fraction, f),
            splat(at.fraction, f),
            leaf.primitive,
            leaf.sbt};
}

// A visitor of triangles (triangle_visitors.h) for moving ones.
template <class Visitor>
struct Moving : Visitor {
    KeySegment at;

    template <class... Arguments>
    SUNSTONE_INLINE_MEMBER explicit Moving(KeySegment segment, Arguments&&... arguments)
        : Visitor{static_cast<Arguments&&>(arguments)...}, at(segment) {}

    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        const void* address = block + offsetOf(ref);
        if ((ref & kNodeTagMask) == kLeaf)
            return Visitor::template visit<F4>(leafAt<4, F4>(address, at));
        return Visitor::template visit<F8>(leafAt<8, F8>(address, at));
    }
};

} // namespace sunstone::bvh::SUNSTONE_ISA
