// SPDX-License-Identifier: Apache-2.0
// The kernels of shapes.h, compiled once per instruction set: the traversal loop with visitors that
// test pieces of curves or spheres. A Judge decides what becomes of a hit.
#pragma once

#include "bvh/curves_body.h"
#include "bvh/spheres_body.h"

namespace sunstone::bvh::SUNSTONE_ISA {

// What visitors need of a block.
struct ShapeArrays {
    const float* points;
    const ShapeRecord* records;
    uint32_t shape, stride; // floats of a primitive in points

    SUNSTONE_INLINE_MEMBER explicit ShapeArrays(const void* block) {
        const BlockHeader& header = *headerOf(block);
        const auto* bytes = static_cast<const uint8_t*>(block);
        points = reinterpret_cast<const float*>(bytes + header.pointsOffset);
        records = reinterpret_cast<const ShapeRecord*>(bytes + header.recordsOffset);
        shape = header.shape;
        stride = isCurveBasis(shape) ? curvePointFloats(CurveBasis(shape), header.motionKeys)
                                     : 4 * header.motionKeys;
    }
};

// Keeps the nearest hit, or with kAny the first that is found.
template <bool kAny>
struct KeepHit {
    static constexpr bool kOrdered = !kAny;
    float tmax;
    bool found = false;
    float u = 0;
    uint32_t number = ~0u, kind = 0;

    SUNSTONE_INLINE_MEMBER bool take(const ShapeArrays&, float t, float place, uint32_t primitive,
                                     uint32_t hitKind) {
        tmax = t;
        u = place;
        number = primitive;
        kind = hitKind;
        found = true;
        return kAny;
    }
};

// Shows hits to a filter.
struct FilterHit {
    static constexpr bool kOrdered = true;
    float tmax;
    const ShapeFilter& filter;

    SUNSTONE_INLINE_MEMBER bool take(const ShapeArrays& arrays, float t, float place,
                                     uint32_t number, uint32_t kind) {
        const ShapeRecord& record = arrays.records[number];
        const ShapeFilter::Answer answer =
            filter.offer(filter.context, {t, place, record.primitive, record.sbt, kind});
        if (answer != ShapeFilter::kIgnore)
            tmax = t;
        return answer == ShapeFilter::kEnd;
    }
};

template <class Judge>
struct CurveVisitor {
    static constexpr bool kOrdered = Judge::kOrdered;
    const RaySpace& space;
    const ShapeArrays& arrays;
    Judge& judge;
    float tmax;

    template <unsigned N>
    SUNSTONE_INLINE_MEMBER bool test(const float* rows) {
        const auto* words = reinterpret_cast<const uint32_t*>(rows);
        const uint32_t kind = kShapeKindBase | (arrays.shape & 15);
        alignas(32) float near[N];
        Lanes<N> distance;
        Mask m = testCapsules<N>(rows + N, space, tmax, distance);
        __builtin_memcpy(near, &distance, sizeof near);
        for (; m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            if (near[i] > tmax * space.length)
                continue;
            const uint32_t number = segmentOf(words[i]);
            CurveCandidate best = {tmax, 0};
            if (!intersectPiece(space, arrays.points + size_t(number) * arrays.stride,
                                CurveBasis(arrays.shape), words[i], arrays.records[number].flags,
                                best))
                continue;
            const bool end = judge.take(arrays, best.t, best.u, number, kind);
            tmax = judge.tmax;
            if (end)
                return true;
        }
        return false;
    }
    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        const auto* rows = reinterpret_cast<const float*>(block + offsetOf(ref));
        return (ref & kNodeTagMask) == kLeaf ? test<4>(rows) : test<8>(rows);
    }
};

template <class Judge>
struct ConeVisitor {
    static constexpr bool kOrdered = Judge::kOrdered;
    const RaySpace& space;
    const ShapeArrays& arrays;
    Judge& judge;
    float tmax;

    template <unsigned N>
    SUNSTONE_INLINE_MEMBER bool test(const float* rows) {
        const auto* words = reinterpret_cast<const uint32_t*>(rows);
        constexpr uint32_t kKind = kShapeKindBase | (uint32_t(CurveBasis::kLinear) & 15);
        alignas(32) float t[N], u[N];
        Lanes<N> laneT, laneU;
        Mask m = testCones<N>(rows + N, space, tmax, laneT, laneU);
        __builtin_memcpy(t, &laneT, sizeof t);
        __builtin_memcpy(u, &laneU, sizeof u);
        for (; m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            const PieceRange range = rangeOf(words[i]);
            // A hit belongs to the piece that it is on.
            if (t[i] > tmax || u[i] < range.begin ||
                (u[i] >= range.begin + range.length && range.begin + range.length < 1))
                continue;
            const bool end = judge.take(arrays, t[i], u[i], segmentOf(words[i]), kKind);
            tmax = judge.tmax;
            if (end)
                return true;
        }
        return false;
    }
    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        const auto* rows = reinterpret_cast<const float*>(block + offsetOf(ref));
        return (ref & kNodeTagMask) == kLeaf ? test<4>(rows) : test<8>(rows);
    }
};

template <class Judge>
struct SphereVisitor {
    static constexpr bool kOrdered = Judge::kOrdered;
    const RaySpace& space;
    const ShapeArrays& arrays;
    Judge& judge;
    float tmax;

    template <unsigned N>
    SUNSTONE_INLINE_MEMBER bool test(const float* rows) {
        const auto* words = reinterpret_cast<const uint32_t*>(rows);
        constexpr uint32_t kKind = kShapeKindBase | (kSphereShape & 15);
        const auto hits = testSpheres<N>(rows + N, space, tmax);
        alignas(32) float enter[N], leave[N];
        __builtin_memcpy(enter, &hits.enter, sizeof enter);
        __builtin_memcpy(leave, &hits.leave, sizeof leave);
        for (Mask m = hits.in | hits.out; m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            const bool front = hits.in >> i & 1;
            const float t = front ? enter[i] : leave[i];
            // A ray that starts before the sphere enters it, or never meets it.
            if (t > tmax)
                continue;
            const bool end = judge.take(arrays, t, 0, words[i],
                                        front ? kKind : kKind | kShapeKindBack);
            tmax = judge.tmax;
            if (end)
                return true;
        }
        return false;
    }
    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        const auto* rows = reinterpret_cast<const float*>(block + offsetOf(ref));
        return (ref & kNodeTagMask) == kLeaf ? test<4>(rows) : test<8>(rows);
    }
};

template <class Judge, template <class> class Visitor>
[[gnu::noinline]] static void walkShapes(const void* block, const RaySetup& setup,
                                         const RaySpace& space, const ShapeArrays& arrays,
                                         Judge& judge) {
    Visitor<Judge> visitor{space, arrays, judge, judge.tmax};
    traverse(block, setup, visitor);
}

template <class Judge>
SUNSTONE_INLINE bool walkShapes(const void* block, const ShapeRay& ray, Judge& judge,
                                const ShapeArrays& arrays) {
    RaySpace space;
    if (!isRay(ray.origin, ray.direction, ray.tmin, ray.tmax) || !setupRaySpace(space, ray))
        return false;
    RaySetup setup;
    setupRay(setup, headerOf(block), ray.origin, ray.direction, ray.tmin, ray.tmax);
    if (arrays.shape == kSphereShape)
        walkShapes<Judge, SphereVisitor>(block, setup, space, arrays, judge);
    else if (arrays.shape == uint32_t(CurveBasis::kLinear))
        walkShapes<Judge, ConeVisitor>(block, setup, space, arrays, judge);
    else
        walkShapes<Judge, CurveVisitor>(block, setup, space, arrays, judge);
    return true;
}

template <bool kAny>
static bool findShape(const void* block, const ShapeRay& ray, ShapeHit& hit) {
    const ShapeArrays arrays(block);
    KeepHit<kAny> judge{ray.tmax};
    if (!walkShapes(block, ray, judge, arrays) || !judge.found)
        return false;
    const ShapeRecord& record = arrays.records[judge.number];
    hit = {judge.tmax, judge.u, record.primitive, record.sbt, judge.kind};
    return true;
}

static void filterShapes(const void* block, const ShapeRay& ray, const ShapeFilter& filter) {
    const ShapeArrays arrays(block);
    FilterHit judge{ray.tmax, filter};
    walkShapes(block, ray, judge, arrays);
}

} // namespace sunstone::bvh::SUNSTONE_ISA
