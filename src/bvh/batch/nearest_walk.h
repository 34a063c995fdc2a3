// SPDX-License-Identifier: Apache-2.0
// The nearest point of a structure's triangles. Included by files that are compiled once per
// instruction set (see bvh/simd.h).
//
// Nodes are visited by the distance of their boxes, the nearest first. Within an instance,
// distances differ from world distances: the world distance of a box is at least `scale` times its
// distance there, where scale is the smallest factor by which the instance changes lengths.
// Triangles are transformed to the world. Boxes are those of rays, a little larger than the
// triangles, so no point is lost. Triangles are tested in double precision: the test has fourth
// powers of lengths, and differences of large coordinates.
#pragma once

#include "bvh/batch/batch.h"
#include "bvh/batch/batch_visitors.h"

namespace sunstone::bvh::SUNSTONE_ISA {

template <class Real>
SUNSTONE_INLINE Real dot3(const Real a[3], const Real b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Computes u and v (at vertices 1 and 2) of the triangle's point nearest to p, from the region of
// the plane that contains p's projection: Ericson, "Real-Time Collision Detection", section 5.1.5.
SUNSTONE_INLINE void nearestOnTriangle(const double p[3], const double v[9], double& u, double& w) {
    double ab[3], ac[3], ap[3], bp[3], cp[3];
    for (int i = 0; i < 3; ++i) {
        ab[i] = v[3 + i] - v[i];
        ac[i] = v[6 + i] - v[i];
        ap[i] = p[i] - v[i];
        bp[i] = p[i] - v[3 + i];
        cp[i] = p[i] - v[6 + i];
    }
    u = w = 0;
    const double d1 = dot3(ab, ap), d2 = dot3(ac, ap);
    if (d1 <= 0 && d2 <= 0)
        return;
    const double d3 = dot3(ab, bp), d4 = dot3(ac, bp);
    if (d3 >= 0 && d4 <= d3) {
        u = 1;
        return;
    }
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        u = d1 / (d1 - d3);
        return;
    }
    const double d5 = dot3(ab, cp), d6 = dot3(ac, cp);
    if (d6 >= 0 && d5 <= d6) {
        w = 1;
        return;
    }
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        w = d2 / (d2 - d6);
        return;
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        u = 1 - w;
        return;
    }
    const double scale = 1 / (va + vb + vc);
    u = vb * scale;
    w = vc * scale;
}

struct NearestWalk {
    const float* point; // in the world
    double best;        // square of the least distance so far
    NearestPoint found{-1, ~0u, ~0u, 0, 0, {0, 0, 0}};

    void take(const double v[9], uint32_t triangle, uint32_t instance) {
        const double p[3] = {point[0], point[1], point[2]};
        double u, w, at[3], square = 0;
        nearestOnTriangle(p, v, u, w);
        for (int i = 0; i < 3; ++i) {
            const double moved = u * (v[3 + i] - v[i]) + w * (v[6 + i] - v[i]);
            const double apart = (v[i] - p[i]) + moved;
            at[i] = v[i] + moved;
            square += apart * apart;
        }
        if (!(square <= best) || (square == best && found.distance >= 0 &&
                                  (instance > found.instance ||
                                   (instance == found.instance && triangle > found.triangle))))
            return;
        best = square;
        found = {float(__builtin_sqrt(square)),
                 triangle,
                 instance,
                 float(u),
                 float(w),
                 {float(at[0]), float(at[1]), float(at[2])}};
    }
    // An upper bound of `best`, for comparison with squared distances of boxes, which may overflow.
    float limit() const {
        constexpr double kLargest = 0x1.fffffep127;
        return best < kLargest ? float(best) * (1 + 0x1p-22f) : __builtin_inff();
    }

    template <unsigned N>
    void visitLeaf(const TriangleLeaf<N>& leaf, const InstanceRecord* record) {
        for (uint32_t lane = 0; lane < leaf.count; ++lane) {
            double v[9];
            for (int i = 0; i < 9; ++i)
                v[i] = leaf.vertices[size_t(i) * N + lane];
            if (record)
                toWorld(*record, v);
            take(v, leaf.primitive[lane], record ? record->index : 0);
        }
    }

    static void toWorld(const InstanceRecord& record, double v[9]) {
        for (int k = 0; k < 3; ++k) {
            const double x = v[3 * k], y = v[3 * k + 1], z = v[3 * k + 2];
            for (int i = 0; i < 3; ++i) {
                const float* const row = record.objectToWorld + 4 * i;
                v[3 * k + i] = row[0] * x + row[1] * y + row[2] * z + row[3];
            }
        }
    }

    // p: the point in the space of the block; scale: square of the factor to the world.
    void walk(const BlockHeader* header, const float p[3], float scale,
              const InstanceRecord* record) {
        if (header->root == kNoNode)
            return;
        F8* const f = nullptr;
        const F8 zero = splat(0.0f, f);
        const auto* const block = reinterpret_cast<const uint8_t*>(header);
        const bool instances = kindOf(header->type) == BlockType::kInstances;
        uint64_t stack[kStackSize];
        uint64_t* top = stack;
        *top++ = header->root;
        while (top != stack) {
            const uint64_t entry = *--top;
            if (__builtin_bit_cast(float, uint32_t(entry >> 32)) > limit())
                continue;
            const NodeRef ref = NodeRef(entry);
            const uint8_t* const at = block + offsetOf(ref);
            if ((ref & kNodeTagMask) == kInner) {
                const Node& node = *reinterpret_cast<const Node*>(at);
                F8 square = zero;
                for (int i = 0; i < 3; ++i) {
                    const F8 c = splat(p[i], f);
                    const F8 gap = max(
                        max(load(node.planes[2 * i], f) - c, c - load(node.planes[2 * i + 1], f)),
                        zero);
                    square = square + gap * gap;
                }
                alignas(32) float distance[8];
                store(distance, square * splat(scale, f));
                uint64_t* const first = top;
                const float most = limit();
                for (uint32_t i = 0; i < node.numChildren; ++i)
                    if (distance[i] <= most)
                        *top++ = uint64_t(bitsOf(distance[i])) << 32 | node.children[i];
                sortEntries(first, unsigned(top - first));
            } else if (instances) {
                enter(*reinterpret_cast<const InstanceRecord*>(at));
            } else if ((ref & kNodeTagMask) == kLeaf) {
                visitLeaf(*reinterpret_cast<const TriangleLeaf<4>*>(at), record);
            } else {
                visitLeaf(*reinterpret_cast<const TriangleLeaf<8>*>(at), record);
            }
        }
    }

    void enter(const InstanceRecord& record) {
        float p[3], sum = 0;
        for (int i = 0; i < 3; ++i) {
            const float* const row = record.worldToObject + 4 * i;
            p[i] = dot3(row, point) + row[3];
            sum += dot3(row, row);
        }
        // The norm of the inverse bounds the factor by which it stretches; the margin is for
        // rounding.
        walk(headerOfHandle(record.child), p, (1 - 0x1p-18f) / sum, &record);
    }
};

static void nearest(uint64_t handle, const float* points, float farthest, NearestPoint* out,
                    uint64_t first, uint64_t end) {
    for (uint64_t i = first; i < end; ++i) {
        const float* const p = points + 3 * i;
        NearestWalk walk{p, double(farthest) * farthest};
        // NaN and infinite points have no nearest point.
        if (finite(absolute(p[0]) + absolute(p[1]) + absolute(p[2])) && farthest >= 0)
            walk.walk(headerOfHandle(handle), p, 1 - 0x1p-20f, nullptr);
        out[i] = walk.found;
    }
}

} // namespace sunstone::bvh::SUNSTONE_ISA
