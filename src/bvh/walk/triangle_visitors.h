// SPDX-License-Identifier: Apache-2.0
// Visitors for structures of triangles without programs during traversal: the nearest hit, and any
// hit. The best hit stays in registers. Included through traverse.h. Visitors of triangles have
// visit<F4 or F8>(leaf), also for leaves with motion (motion_traverse.h); true ends the traversal.
#pragma once

#include "bvh/walk/traverse.h"

namespace sunstone::bvh::SUNSTONE_ISA {

// The culled sides. A ray meets the front of a triangle if its vertices are counter-clockwise as
// seen by the ray; the determinant of the test is then positive.
struct Culling {
    bool front = false, back = false;

    SUNSTONE_INLINE_MEMBER bool drops(float det, uint32_t sbt) const {
        if (!(front | back) || (sbt >> kGeometryFlagShift & kGeometryDisableFaceCulling))
            return false;
        return det > 0 ? front : back;
    }
};

// Passes the triangles of a leaf without motion to the visitor.
template <class Visitor>
SUNSTONE_INLINE bool visitTriangles(Visitor& visitor, const uint8_t* block, NodeRef ref) {
    const void* address = block + offsetOf(ref);
    if ((ref & kNodeTagMask) == kLeaf)
        return visitor.template visit<F4>(*static_cast<const TriangleLeaf<4>*>(address));
    return visitor.template visit<F8>(*static_cast<const TriangleLeaf<8>*>(address));
}

// Finds the hit with the smallest t, among equal hits that of the lowest primitive index, so that
// the result does not depend on the order of visits.
struct ClosestTriangle {
    static constexpr bool kOrdered = true;

    const RaySetup& setup;
    Culling culling;
    float tmax;
    bool found = false;
    float v = 0, w = 0, det = 1; // of the best hit, see TriangleCandidates
    uint32_t primitive = ~0u, sbt = 0;

    SUNSTONE_INLINE_MEMBER ClosestTriangle(const RaySetup& s, float tmax, Culling culling)
        : setup(s), culling(culling), tmax(tmax) {}

    template <class F, class Leaf>
    SUNSTONE_INLINE_MEMBER bool visit(const Leaf& leaf) {
        constexpr unsigned N = F::kLanes;
        TriangleCandidates<N> c;
        for (Mask m = testTriangles<N, F>(leaf, setup, tmax, c); m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            if (c.t[i] > tmax || (c.t[i] == tmax && found && leaf.primitive[i] > primitive) ||
                culling.drops(c.det[i], leaf.sbt[i]))
                continue;
            found = true;
            tmax = c.t[i];
            v = c.v[i];
            w = c.w[i];
            det = c.det[i];
            primitive = leaf.primitive[i];
            sbt = leaf.sbt[i];
        }
        return false;
    }

    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        return visitTriangles(*this, block, ref);
    }
};

// Stops at the first hit found.
struct AnyTriangle {
    static constexpr bool kOrdered = false;

    const RaySetup& setup;
    Culling culling;
    float tmax;
    bool found = false;

    SUNSTONE_INLINE_MEMBER AnyTriangle(const RaySetup& s, float tmax, Culling culling)
        : setup(s), culling(culling), tmax(tmax) {}

    template <class F, class Leaf>
    SUNSTONE_INLINE_MEMBER bool visit(const Leaf& leaf) {
        constexpr unsigned N = F::kLanes;
        TriangleCandidates<N> c;
        for (Mask m = testTriangles<N, F>(leaf, setup, tmax, c); m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            if (!culling.drops(c.det[i], leaf.sbt[i])) {
                found = true;
                return true;
            }
        }
        return false;
    }

    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        return visitTriangles(*this, block, ref);
    }
};

} // namespace sunstone::bvh::SUNSTONE_ISA
