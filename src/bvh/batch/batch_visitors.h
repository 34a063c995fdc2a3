// SPDX-License-Identifier: Apache-2.0
// Single rays of a batch: the handling of candidates, and the traversal of triangles and instances.
// Included by files that are compiled once per instruction set (see bvh/simd.h).
//
// A Judge has
//   static constexpr bool kOrdered;    near children first
//   float tmax;                        candidates beyond it do not count
//   uint32_t instance;                 of the candidates that come, ~0u without instances
//   Judge(ray)                         for the walk of this ray
//   bool take(t, v, w, det, triangle, sbt)  a candidate; true ends the walk
//   Hit hit()                          the outcome; that of a new Judge is a miss
#pragma once

#include "bvh/batch/ray_batch.h"
#include "bvh/walk/traverse.h"

namespace sunstone::bvh::SUNSTONE_ISA {

struct ClosestJudge {
    static constexpr bool kOrdered = true;
    using Hit = BatchHit;
    float tmax = 0;
    uint32_t instance = ~0u;
    bool found = false;
    float v = 0, w = 0, det = 1;
    uint32_t triangle = ~0u, hitInstance = ~0u;

    ClosestJudge() = default;
    SUNSTONE_INLINE_MEMBER explicit ClosestJudge(const BatchRay& ray) : tmax(ray.tmax) {}
    SUNSTONE_INLINE_MEMBER bool take(float t, float cv, float cw, float cdet, uint32_t id,
                                     uint32_t) {
        if (t > tmax || (t == tmax && found &&
                         (instance > hitInstance || (instance == hitInstance && id > triangle))))
            return false;
        found = true;
        tmax = t;
        v = cv;
        w = cw;
        det = cdet;
        triangle = id;
        hitInstance = instance;
        return false;
    }
    SUNSTONE_INLINE_MEMBER BatchHit hit() const {
        if (!found)
            return kNoBatchHit;
        return {tmax, triangle, hitInstance == ~0u ? 0u : hitInstance, v / det, w / det};
    }
};

struct AnyJudge : ClosestJudge {
    static constexpr bool kOrdered = false;
    using ClosestJudge::ClosestJudge;
    SUNSTONE_INLINE_MEMBER bool take(float t, float cv, float cw, float cdet, uint32_t id,
                                     uint32_t) {
        found = true;
        tmax = t;
        v = cv;
        w = cw;
        det = cdet;
        triangle = id;
        hitInstance = instance;
        return true;
    }
};

// Tests the triangles of a structure and passes candidates to a judge.
template <class Judge, bool kMasked>
struct BatchTriangles {
    static constexpr bool kOrdered = Judge::kOrdered;
    const RaySetup& setup;
    Judge& judge;
    const uint32_t* masks; // null: none
    uint32_t mask;
    float tmax;

    SUNSTONE_INLINE_MEMBER BatchTriangles(const RaySetup& s, Judge& j,
                                          const uint32_t* triangleMasks, uint32_t rayMask)
        : setup(s), judge(j), masks(triangleMasks), mask(rayMask), tmax(j.tmax) {}

    template <unsigned N, class F>
    SUNSTONE_INLINE_MEMBER bool visit(const TriangleLeaf<N>& leaf) {
        TriangleCandidates<N> c;
        for (Mask m = testTriangles<N, F>(leaf, setup, tmax, c); m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            if (kMasked && masks && !(masks[leaf.primitive[i]] & mask))
                continue;
            if (judge.take(c.t[i], c.v[i], c.w[i], c.det[i], leaf.primitive[i], leaf.sbt[i]))
                return true;
        }
        tmax = judge.tmax;
        return false;
    }

    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        const void* const address = block + offsetOf(ref);
        if ((ref & kNodeTagMask) == kLeaf)
            return visit<4, F4>(*static_cast<const TriangleLeaf<4>*>(address));
        return visit<8, F8>(*static_cast<const TriangleLeaf<8>*>(address));
    }
};

SUNSTONE_INLINE const BlockHeader* headerOfHandle(uint64_t handle) {
    return reinterpret_cast<const BlockHeader*>(handle & ~uint64_t(devlib::kTagMask));
}

// The structure that a batch's rays traverse.
struct BatchScene {
    const BlockHeader* header;
    uint64_t masks; // as in RayBatch
    bool instances;

    SUNSTONE_INLINE_MEMBER BatchScene(uint64_t handle, uint64_t triangleMasks)
        : header(headerOfHandle(handle)), masks(triangleMasks),
          instances(kindOf(header->type) == BlockType::kInstances) {}
    SUNSTONE_INLINE_MEMBER const uint32_t* masksOf(uint32_t instance) const {
        if (!instances)
            return reinterpret_cast<const uint32_t*>(masks);
        return masks ? reinterpret_cast<const uint32_t*>(
                           reinterpret_cast<const uint64_t*>(masks)[instance])
                     : nullptr;
    }
};

// The ray in the space of an instance.
SUNSTONE_INLINE void toObject(const InstanceRecord& record, const BatchRay& ray, float origin[3],
                              float direction[3]) {
    for (int i = 0; i < 3; ++i) {
        const float* const row = record.worldToObject + 4 * i;
        origin[i] =
            row[0] * ray.origin[0] + row[1] * ray.origin[1] + row[2] * ray.origin[2] + row[3];
        direction[i] =
            row[0] * ray.direction[0] + row[1] * ray.direction[1] + row[2] * ray.direction[2];
    }
}

template <class Judge, bool kMasked>
struct BatchInstances {
    static constexpr bool kOrdered = Judge::kOrdered;
    const BatchScene& scene;
    const BatchRay& ray;
    Judge& judge;
    float tmax;

    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        const auto& record = *reinterpret_cast<const InstanceRecord*>(block + offsetOf(ref));
        float origin[3], direction[3];
        toObject(record, ray, origin, direction);
        const BlockHeader* const header = headerOfHandle(record.child);
        if (header->root == kNoNode || !isRay(origin, direction, ray.tmin, judge.tmax))
            return false;
        judge.instance = record.index;
        const bool ended = walkTriangles(*header, origin, direction,
                                         kMasked ? scene.masksOf(record.index) : nullptr);
        tmax = judge.tmax;
        return ended;
    }

private:
    [[gnu::noinline]] bool walkTriangles(const BlockHeader& header, const float origin[3],
                                         const float direction[3], const uint32_t* masks) {
        RaySetup setup;
        setupRay(setup, &header, origin, direction, ray.tmin, judge.tmax);
        Judge mine = judge; // in registers
        BatchTriangles<Judge, kMasked> triangles(setup, mine, masks, ray.mask);
        traverse(&header, setup, triangles);
        judge = mine;
        return !Judge::kOrdered && mine.found;
    }
};

// Traces one ray, for which isRay() holds.
template <class Judge, bool kMasked>
SUNSTONE_INLINE void walkOne(const BatchScene& scene, const BatchRay& ray, const RaySetup& setup,
                             Judge& judge) {
    if (!scene.instances) {
        BatchTriangles<Judge, kMasked> triangles(setup, judge, kMasked ? scene.masksOf(0) : nullptr,
                                                 ray.mask);
        traverse(scene.header, setup, triangles);
    } else {
        BatchInstances<Judge, kMasked> instances{scene, ray, judge, judge.tmax};
        traverse(scene.header, setup, instances);
    }
}

} // namespace sunstone::bvh::SUNSTONE_ISA
