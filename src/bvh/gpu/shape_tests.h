// SPDX-License-Identifier: Apache-2.0
// Rays against curves and spheres on GPUs: the CPU's tests (bvh/curves_body.h, bvh/spheres_body.h)
// with one lane, which is the thread. They contract products and sums as the CPU's do where it has
// fused operations, so that both give the same numbers.
#pragma once

#include "bvh/gpu/layout.h"
#include "bvh/gpu/portable.h"
#include "bvh/shapes.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif
#if defined(__NVPTX__)
#pragma clang fp contract(on)
#endif

#include "bvh/curves_body.h"
#include "bvh/spheres_body.h"

namespace sunstone::bvh::gpu {

namespace lane = bvh::SUNSTONE_ISA;

SUNSTONE_GPU_INLINE bool meetsShape(uint32_t bits, uint32_t shape) {
    return bits & (shape == kSphereShape                      ? kMeetsSpheres
                   : CurveBasis(shape) == CurveBasis::kLinear ? kMeetsLinear
                                                              : kMeetsCurves);
}

// Rows of a record as single lanes stand in memory.
SUNSTONE_GPU_INLINE void unpack(U4 words, float* to) {
    to[0] = floatOf(words.x);
    to[1] = floatOf(words.y);
    to[2] = floatOf(words.z);
    to[3] = floatOf(words.w);
}

SUNSTONE_GPU_INLINE bool testSphere(const U4* record, const lane::RaySpace& s, float tmax,
                                    ShapeHit& hit) {
    constexpr uint32_t kKind = kShapeKindBase | (kSphereShape & 15);
    float rows[4];
    unpack(loadConstant(record), rows);
    const auto hits = lane::testSpheres<1>(rows, s, tmax);
    if (!(hits.in | hits.out))
        return false;
    const U4 rest = loadConstant(record + 1);
    hit = {hits.in ? hits.enter[0] : hits.leave[0], 0, rest.x, rest.y,
           hits.in ? kKind : kKind | kShapeKindBack};
    return true;
}

SUNSTONE_GPU_INLINE bool testLinear(const U4* record, const lane::RaySpace& s, float tmax,
                                    ShapeHit& hit) {
    constexpr uint32_t kKind = kShapeKindBase | (uint32_t(CurveBasis::kLinear) & 15);
    float rows[8];
    unpack(loadConstant(record), rows);
    unpack(loadConstant(record + 1), rows + 4);
    lane::Lanes<1> t, u;
    if (!lane::testCones<1>(rows, s, tmax, t, u))
        return false;
    const U4 rest = loadConstant(record + 2);
    // A hit belongs to the piece that it is on.
    const PieceRange range = rangeOf(rest.x);
    if (u[0] < range.begin ||
        (u[0] >= range.begin + range.length && range.begin + range.length < 1))
        return false;
    hit = {t[0], u[0], rest.y, rest.z, kKind};
    return true;
}

// Apart from the loop, whose registers it would take. False, or the hit in `best`.
[[gnu::noinline]] static bool testPiece(const lane::RaySpace& space, const float* points,
                                        uint32_t shape, uint32_t word, uint32_t flags,
                                        lane::CurveCandidate& best) {
    return lane::intersectPiece<1>(space, points, CurveBasis(shape), word, flags, best);
}

SUNSTONE_GPU_INLINE bool testCurve(const BlockHeader* block, const U4* record,
                                   const lane::RaySpace& s, float tmax, ShapeHit& hit) {
    float rows[8];
    unpack(loadConstant(record), rows);
    unpack(loadConstant(record + 1), rows + 4);
    lane::Lanes<1> near;
    if (!lane::testCapsules<1>(rows, s, tmax, near))
        return false;
    const U4 rest = loadConstant(record + 2);
    const uint32_t shape = block->shape, stride = curvePointFloats(CurveBasis(shape), 1);
    const auto* const points = reinterpret_cast<const float*>(
        reinterpret_cast<const uint8_t*>(block) + block->pointsOffset);
    const lane::RaySpace copy = s; // so that the walk's own is not in memory
    lane::CurveCandidate best = {tmax, 0};
    if (!testPiece(copy, points + uint64_t(segmentOf(rest.x)) * stride, shape, rest.x, rest.w,
                   best))
        return false;
    hit = {best.t, best.u, rest.y, rest.z, kShapeKindBase | (shape & 15)};
    return true;
}

// A record of a block of curves or spheres.
SUNSTONE_GPU_INLINE bool testShape(uint32_t bits, const BlockHeader* block, const uint8_t* records,
                                   uint32_t record, const lane::RaySpace& s, float tmax,
                                   ShapeHit& hit) {
    const bool sphere =
        bits == kMeetsSpheres || ((bits & kMeetsSpheres) && block->shape == kSphereShape);
    if (sphere)
        return testSphere(
            reinterpret_cast<const U4*>(records + uint64_t(record) * sizeof(SphereRecord)), s, tmax,
            hit);
    const auto* const curve =
        reinterpret_cast<const U4*>(records + uint64_t(record) * sizeof(CurveRecord));
    const bool linear = !(bits & kMeetsCurves) ||
                        ((bits & kMeetsLinear) && block->shape == uint32_t(CurveBasis::kLinear));
    if (linear)
        return testLinear(curve, s, tmax, hit);
    return testCurve(block, curve, s, tmax, hit);
}

} // namespace sunstone::bvh::gpu

#if defined(__NVPTX__)
#pragma clang fp contract(off)
#endif
#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
