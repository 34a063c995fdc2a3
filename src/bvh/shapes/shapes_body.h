// SPDX-License-Identifier: Apache-2.0
// The kernels of shapes.h, compiled once per instruction set: the traversal loop with visitors that
// test pieces of curves or spheres. A Judge accepts or rejects each hit.
#pragma once

#include "bvh/motion/motion_traverse.h"
#include "bvh/shapes/curves_body.h"
#include "bvh/shapes/shapes.h"
#include "bvh/shapes/spheres_body.h"

namespace sunstone::bvh::SUNSTONE_ISA {

// The parts of a block that visitors need.
struct ShapeArrays {
    const float* points;
    const ShapeRecord* records;
    uint32_t shape, stride; // floats of a primitive in points, at all keys
    KeySegment at = {0, 0}; // with motion: the ray's time

    SUNSTONE_INLINE_MEMBER explicit ShapeArrays(const void* block) {
        const BlockHeader& header = *headerOf(block);
        const auto* bytes = static_cast<const uint8_t*>(block);
        points = reinterpret_cast<const float*>(bytes + header.pointsOffset);
        records = reinterpret_cast<const ShapeRecord*>(bytes + header.recordsOffset);
        shape = header.shape;
        stride = isCurveBasis(shape) ? curvePointFloats(CurveBasis(shape), header.motionKeys)
                                     : 4 * header.motionKeys;
    }

    // The first `count` of a moving primitive's numbers at the ray's time.
    SUNSTONE_INLINE_MEMBER void interpolate(uint32_t number, uint32_t count, float* to) const {
        const uint32_t floats = isCurveBasis(shape) ? curvePointFloats(CurveBasis(shape), 1) : 4;
        const float* const from = points + size_t(number) * stride + at.key * floats;
        for (uint32_t i = 0; i < count; ++i)
            to[i] = between(from[i], from[floats + i], at.fraction);
    }
};

// Keeps the nearest hit, among equal hits that of the lowest primitive; with kAny the first hit
// found.
template <bool kAny>
struct KeepHit {
    static constexpr bool kOrdered = !kAny;
    float tmax;
    bool found = false;
    float u = 0;
    uint32_t number = ~0u, kind = 0;

    SUNSTONE_INLINE_MEMBER bool take(const ShapeArrays& arrays, float t, float place,
                                     uint32_t primitive, uint32_t hitKind) {
        if (t == tmax && found &&
            arrays.records[primitive].primitive > arrays.records[number].primitive)
            return false;
        tmax = t;
        u = place;
        number = primitive;
        kind = hitKind;
        found = true;
        return kAny;
    }
};

// Passes hits to a filter.
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

// Passes a leaf, whose words are its row 0, to the visitor's test().
template <class Visitor>
SUNSTONE_INLINE bool visitRows(Visitor& visitor, const uint8_t* block, NodeRef ref) {
    const auto* words = reinterpret_cast<const uint32_t*>(block + offsetOf(ref));
    const auto* rows = reinterpret_cast<const float*>(words);
    return (ref & kNodeTagMask) == kLeaf ? visitor.template test<4>(words, rows + 4)
                                         : visitor.template test<8>(words, rows + 8);
}

template <class Judge>
struct CurveVisitor {
    static constexpr bool kOrdered = Judge::kOrdered;
    const RaySpace& space;
    const ShapeArrays& arrays;
    Judge& judge;
    float tmax;

    // Row 0 of a leaf, and the rows behind it.
    template <unsigned N>
    SUNSTONE_INLINE_MEMBER bool test(const uint32_t* words, const float* rows) {
        const uint32_t kind = devlib::kHitShape | (arrays.shape & 15);
        alignas(32) float near[N];
        Lanes<N> distance;
        Mask m = testCapsules<N>(rows, space, tmax, distance);
        __builtin_memcpy(near, &distance, sizeof near);
        for (; m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            if (near[i] > tmax * space.length)
                continue;
            const uint32_t number = segmentOf(words[i]);
            CurveCandidate best = {tmax, 0};
            if (!intersectPiece<8>(space, arrays.points + size_t(number) * arrays.stride,
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
        return visitRows(*this, block, ref);
    }
};

template <class Judge>
struct ConeVisitor {
    static constexpr bool kOrdered = Judge::kOrdered;
    const RaySpace& space;
    const ShapeArrays& arrays;
    Judge& judge;
    float tmax;

    // Row 0 of a leaf, and the rows behind it.
    template <unsigned N>
    SUNSTONE_INLINE_MEMBER bool test(const uint32_t* words, const float* rows) {
        constexpr uint32_t kKind = devlib::kHitShape | (uint32_t(CurveBasis::kLinear) & 15);
        alignas(32) float t[N], u[N];
        Lanes<N> laneT, laneU;
        Mask m = testCones<N>(rows, space, tmax, laneT, laneU);
        __builtin_memcpy(t, &laneT, sizeof t);
        __builtin_memcpy(u, &laneU, sizeof u);
        for (; m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            const PieceRange range = rangeOf(words[i]);
            // A hit counts only for the piece that contains it.
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
        return visitRows(*this, block, ref);
    }
};

template <class Judge>
struct SphereVisitor {
    static constexpr bool kOrdered = Judge::kOrdered;
    const RaySpace& space;
    const ShapeArrays& arrays;
    Judge& judge;
    float tmax;

    // Row 0 of a leaf, and the rows behind it.
    template <unsigned N>
    SUNSTONE_INLINE_MEMBER bool test(const uint32_t* words, const float* rows) {
        constexpr uint32_t kKind = devlib::kHitShape | (kSphereShape & 15);
        const auto hits = testSpheres<N>(rows, space, tmax);
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
            const bool end =
                judge.take(arrays, t, 0, words[i], front ? kKind : kKind | devlib::kHitShapeBack);
            tmax = judge.tmax;
            if (end)
                return true;
        }
        return false;
    }
    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        return visitRows(*this, block, ref);
    }
};

// Curves that move: a leaf's capsules are interpolated (curves.h), and pieces that the ray may meet
// are tested at that time.
template <class Judge>
struct MovingCurveVisitor {
    static constexpr bool kOrdered = Judge::kOrdered;
    const RaySpace& space;
    const ShapeArrays& arrays;
    Judge& judge;
    float tmax;

    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        return visitRows(*this, block, ref);
    }
    // Row 0 of a leaf, and the rows behind it.
    template <unsigned N>
    SUNSTONE_INLINE_MEMBER bool test(const uint32_t* words, const float* rows) {
        const CurveBasis basis = CurveBasis(arrays.shape);
        const uint32_t kind = devlib::kHitShape | (arrays.shape & 15);
        constexpr uint32_t kKeyFloats = (kCurveRows - 1) * N;
        alignas(32) float now[kKeyFloats], near[N];
        rows += arrays.at.key * kKeyFloats;
        for (uint32_t i = 0; i < kKeyFloats; ++i)
            now[i] = between(rows[i], rows[kKeyFloats + i], arrays.at.fraction);
        Lanes<N> distance;
        Mask m = testCapsules<N>(now, space, tmax, distance);
        __builtin_memcpy(near, &distance, sizeof near);
        for (; m; m &= m - 1) {
            const unsigned i = lowestBit(m);
            if (near[i] > tmax * space.length)
                continue;
            const uint32_t number = segmentOf(words[i]);
            alignas(16) float points[16];
            arrays.interpolate(number, curvePointFloats(basis, 1), points);
            CurveCandidate best = {tmax, 0};
            if (!intersectPiece<8>(space, points, basis, words[i], arrays.records[number].flags,
                                   best))
                continue;
            const bool end = judge.take(arrays, best.t, best.u, number, kind);
            tmax = judge.tmax;
            if (end)
                return true;
        }
        return false;
    }
};

// Linear segments and spheres that move: a leaf at that time. Radii below zero are clamped after
// the interpolation.
template <class Visitor, unsigned kFloats>
struct MovingLanes : Visitor {
    SUNSTONE_INLINE_MEMBER bool leaf(const uint8_t* block, NodeRef ref) {
        const auto* words = reinterpret_cast<const uint32_t*>(block + offsetOf(ref));
        return (ref & kNodeTagMask) == kLeaf ? testAt<4>(words) : testAt<8>(words);
    }

private:
    template <unsigned N>
    SUNSTONE_INLINE_MEMBER bool testAt(const uint32_t* words) {
        alignas(32) float rows[kFloats * N];
        for (uint32_t lane = 0; lane < N; ++lane) {
            float points[kFloats];
            lanePoints(words[lane], points);
            // The rows have positions first, then radii.
            constexpr uint32_t kPoints = kFloats / 4;
            for (uint32_t p = 0; p < kPoints; ++p) {
                for (uint32_t axis = 0; axis < 3; ++axis)
                    rows[(3 * p + axis) * N + lane] = points[4 * p + axis];
                rows[(3 * kPoints + p) * N + lane] = points[4 * p + 3];
            }
        }
        return this->template test<N>(words, rows);
    }
    // NaN if no surface can be hit.
    SUNSTONE_INLINE_MEMBER void lanePoints(uint32_t word, float* points) const {
        const uint32_t number = kFloats == 4 ? word : segmentOf(word);
        if (word == kNoPiece || (this->arrays.records[number].flags & kShapeInactive)) {
            for (uint32_t i = 0; i < kFloats; ++i)
                points[i] = __builtin_nanf("");
            return;
        }
        this->arrays.interpolate(number, kFloats, points);
        for (uint32_t i = 3; i < kFloats; i += 4)
            points[i] = points[i] > 0 ? points[i] : 0;
    }
};
template <class Judge>
struct MovingConeVisitor : MovingLanes<ConeVisitor<Judge>, 8> {};
template <class Judge>
struct MovingSphereVisitor : MovingLanes<SphereVisitor<Judge>, 4> {};

template <class Judge, template <class> class Visitor>
[[gnu::noinline]] static void walkMoving(const void* block, const RaySetup& setup,
                                         const RaySpace& space, const ShapeArrays& arrays,
                                         Judge& judge) {
    Visitor<Judge> visitor{space, arrays, judge, judge.tmax};
    traverseNodes(block, MovingNodes(*headerOf(block), setup, arrays.at), visitor);
}

template <class Judge>
[[gnu::noinline]] static void walkMovingShapes(const void* block, const RaySetup& setup,
                                               const RaySpace& space, ShapeArrays arrays,
                                               float time, Judge& judge) {
    const BlockHeader& header = *headerOf(block);
    if (hasVanished(header.motionFlags, header.motionBegin, header.motionEnd, time))
        return;
    arrays.at = keySegment(header, time);
    if (arrays.shape == kSphereShape)
        walkMoving<Judge, MovingSphereVisitor>(block, setup, space, arrays, judge);
    else if (arrays.shape == uint32_t(CurveBasis::kLinear))
        walkMoving<Judge, MovingConeVisitor>(block, setup, space, arrays, judge);
    else
        walkMoving<Judge, MovingCurveVisitor>(block, setup, space, arrays, judge);
}

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
    if (!isRay(ray.origin, ray.direction, ray.tmin, ray.tmax) ||
        !setupRaySpace(space, ray.origin, ray.direction, ray.tmin))
        return false;
    RaySetup setup;
    setupRay(setup, headerOf(block), ray.origin, ray.direction, ray.tmin, ray.tmax);
    if (headerOf(block)->motionKeys > 1)
        walkMovingShapes(block, setup, space, arrays, ray.time, judge);
    else if (arrays.shape == kSphereShape)
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
