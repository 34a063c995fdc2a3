// SPDX-License-Identifier: Apache-2.0
// Rays against curves and spheres on GPUs: the CPU's tests (bvh/shapes/curves_body.h,
// bvh/shapes/spheres_body.h) with one lane, the thread. The compiler may fuse more products and
// sums here than on the CPU, so that results can differ in the last bit. With kMotion a structure
// may have motion keys: its records and points are then interpolated at the ray's time, as on the
// CPU (bvh/shapes/shapes_body.h).
#pragma once

#include "bvh/gpu/layout.h"
#include "bvh/gpu/walk/motion_traversal.h"
#include "bvh/shapes/shapes.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif
#if defined(__NVPTX__)
#pragma clang fp contract(on)
#endif

#include "bvh/shapes/curves_body.h"
#include "bvh/shapes/spheres_body.h"

namespace sunstone::bvh::gpu {

namespace lane = bvh::SUNSTONE_ISA;

SUNSTONE_INLINE bool meetsShape(uint32_t bits, uint32_t shape) {
    return bits & (shape == kSphereShape                      ? kMeetsSpheres
                   : CurveBasis(shape) == CurveBasis::kLinear ? kMeetsLinear
                                                              : kMeetsCurves);
}

// Rows of a record, as single lanes in memory.
SUNSTONE_INLINE void unpack(U4 words, float* to) {
    to[0] = floatOf(words.x);
    to[1] = floatOf(words.y);
    to[2] = floatOf(words.z);
    to[3] = floatOf(words.w);
}

// Loads four rows of a record, the one of place.key. With motion, the record of the next key is
// `units` words further.
template <bool kMotion>
SUNSTONE_INLINE void loadRows(const U4* record, uint32_t units, const MotionPlace& place,
                              float rows[4]) {
    unpack(loadConstant(record), rows);
    if (!kMotion || place.keys == 1)
        return;
    float next[4];
    unpack(loadConstant(record + units), next);
    for (int i = 0; i < 4; ++i)
        rows[i] = weighted(rows[i], next[i], place);
}

// Interpolated radii below zero count as zero. (Without motion no radius is negative.)
template <bool kMotion>
SUNSTONE_INLINE void clampRadius(float& radius) {
    if (kMotion)
        radius = radius > 0 ? radius : 0;
}

template <bool kMotion>
SUNSTONE_INLINE bool testSphere(const U4* record, const MotionPlace& place, const lane::RaySpace& s,
                                float tmax, ShapeHit& hit) {
    constexpr uint32_t kKind = devlib::kHitShape | (kSphereShape & 15);
    float rows[4];
    loadRows<kMotion>(record, sizeof(SphereRecord) / 16, place, rows);
    clampRadius<kMotion>(rows[3]);
    const auto hits = lane::testSpheres<1>(rows, s, tmax);
    if (!(hits.in | hits.out))
        return false;
    const U4 rest = loadConstant(record + 1);
    hit = {hits.in ? hits.enter[0] : hits.leave[0], 0, rest.x, rest.y,
           hits.in ? kKind : kKind | devlib::kHitShapeBack};
    return true;
}

constexpr uint32_t kCurveUnits = sizeof(CurveRecord) / 16;

template <bool kMotion>
SUNSTONE_INLINE bool testLinear(const U4* record, const MotionPlace& place, const lane::RaySpace& s,
                                float tmax, ShapeHit& hit) {
    constexpr uint32_t kKind = devlib::kHitShape | (uint32_t(CurveBasis::kLinear) & 15);
    float rows[8];
    loadRows<kMotion>(record, kCurveUnits, place, rows);
    loadRows<kMotion>(record + 1, kCurveUnits, place, rows + 4);
    clampRadius<kMotion>(rows[6]);
    clampRadius<kMotion>(rows[7]);
    lane::Lanes<1> t, u;
    if (!lane::testCones<1>(rows, s, tmax, t, u))
        return false;
    const U4 rest = loadConstant(record + 2);
    // A hit counts only for the piece that contains it.
    const PieceRange range = rangeOf(rest.x);
    if (u[0] < range.begin ||
        (u[0] >= range.begin + range.length && range.begin + range.length < 1))
        return false;
    hit = {t[0], u[0], rest.y, rest.z, kKind};
    return true;
}

// Stores the hit in `best`; false if there is none. Inlined: as a function it saves and restores 57
// registers in pipelines with callables (docs/notes/programs-gpu.md).
SUNSTONE_INLINE bool testPiece(const lane::RaySpace& space, const float* points, uint32_t shape,
                               uint32_t word, uint32_t flags, lane::CurveCandidate& best) {
    return lane::intersectPiece<1>(space, points, CurveBasis(shape), word, flags, best);
}

// testPiece() for points between two keys: `points` are those of place.key; those of the next key
// are `floats` further.
[[gnu::noinline]] static bool testMovingPiece(const lane::RaySpace& space, const float* points,
                                              uint32_t floats, const MotionPlace& place,
                                              uint32_t shape, uint32_t word, uint32_t flags,
                                              lane::CurveCandidate& best) {
    alignas(16) float now[16];
    for (uint32_t i = 0; i < floats; ++i)
        now[i] = weighted(points[i], points[floats + i], place);
    return lane::intersectPiece<1>(space, now, CurveBasis(shape), word, flags, best);
}

// Whether the ray meets the capsule around the piece of a curve.
template <bool kMotion>
SUNSTONE_INLINE bool meetsCapsule(const U4* record, const MotionPlace& place,
                                  const lane::RaySpace& s, float tmax) {
    float rows[8];
    loadRows<kMotion>(record, kCurveUnits, place, rows);
    loadRows<kMotion>(record + 1, kCurveUnits, place, rows + 4);
    lane::Lanes<1> near;
    return lane::testCapsules<1>(rows, s, tmax, near);
}

// The basis of a block of curves with pieces, a constant where rays can meet only one.
SUNSTONE_INLINE uint32_t basisOf(uint32_t bits, uint32_t shape) {
    switch (bits & (kMeetsQuadratic | kMeetsCubic | kMeetsCatmullRom)) {
    case kMeetsQuadratic:
        return uint32_t(CurveBasis::kQuadraticBSpline);
    case kMeetsCubic:
        return uint32_t(CurveBasis::kCubicBSpline);
    case kMeetsCatmullRom:
        return uint32_t(CurveBasis::kCatmullRom);
    default:
        return shape;
    }
}

// The piece itself.
template <bool kMotion>
SUNSTONE_INLINE bool testCurve(uint32_t bits, const BlockHeader* block, uint32_t ofBlock,
                               const U4* record, const MotionPlace& place, const lane::RaySpace& s,
                               float tmax, ShapeHit& hit) {
    const U4 rest = loadConstant(record + 2);
    const uint32_t shape = basisOf(bits, ofBlock), stride = curvePointFloats(CurveBasis(shape), 1);
    const auto* const points = reinterpret_cast<const float*>(
        reinterpret_cast<const uint8_t*>(block) + block->pointsOffset);
    const lane::RaySpace copy = s; // so that the traversal's own stays in registers
    lane::CurveCandidate best = {tmax, 0};
    const uint64_t segment = segmentOf(rest.x);
    bool met;
    if (kMotion && place.keys > 1) {
        const MotionPlace at = place;
        met = testMovingPiece(copy, points + (segment * at.keys + at.key) * stride, stride, at,
                              shape, rest.x, rest.w, best);
    } else {
        met = testPiece(copy, points + segment * stride, shape, rest.x, rest.w, best);
    }
    if (!met)
        return false;
    hit = {best.t, best.u, rest.y, rest.z, devlib::kHitShape | (shape & 15)};
    return true;
}

// Whether the block has curves whose pieces take long to test; `bits` are the shapes that may be
// met.
SUNSTONE_INLINE bool isOfPieces(uint32_t bits, uint32_t shape) {
    if (!(bits & kMeetsCurves))
        return false;
    return !(bits & (kMeetsSpheres | kMeetsLinear)) ||
           (shape != kSphereShape && shape != uint32_t(CurveBasis::kLinear));
}

// Tests a record of a block of spheres or linear curves; `records` are those of place.key.
template <bool kMotion>
SUNSTONE_INLINE bool testShape(uint32_t bits, uint32_t shape, const uint8_t* records,
                               uint32_t record, const MotionPlace& place, const lane::RaySpace& s,
                               float tmax, ShapeHit& hit) {
    const uint64_t index = kMotion ? uint64_t(record) * place.keys : record;
    const bool sphere = !(bits & kMeetsLinear) || ((bits & kMeetsSpheres) && shape == kSphereShape);
    if (sphere)
        return testSphere<kMotion>(
            reinterpret_cast<const U4*>(records + index * sizeof(SphereRecord)), place, s, tmax,
            hit);
    return testLinear<kMotion>(reinterpret_cast<const U4*>(records + index * sizeof(CurveRecord)),
                               place, s, tmax, hit);
}

} // namespace sunstone::bvh::gpu

#if defined(__NVPTX__)
#pragma clang fp contract(off)
#endif
#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
