// SPDX-License-Identifier: Apache-2.0
// Rules of hits, as pure functions that the run-times of CPUs and GPUs share: whether the any-hit
// program runs, whether flags drop the hit, which face was hit, the state after an accepted hit,
// and which traversables do not fit a pipeline. Source: OptiX API reference 7.4, sections 3.12.4.12
// (ray flags), 3.12.4.9 (instance flags) and 3.12.4.7 (geometry flags).
#pragma once

#include "bvh/layout.h"
#include "devlib/flags.h"
#include "devlib/records.h"

namespace sunstone::devlib {

// Whether any-hit is enabled by geometry and instance; the ray's flags apply after that.
SUNSTONE_INLINE bool anyHitEnabled(uint32_t instanceFlags, uint32_t sbtWord) {
    if (instanceFlags & (kInstanceDisableAnyHit | kInstanceEnforceAnyHit))
        return (instanceFlags & kInstanceDisableAnyHit) == 0;
    return (sbtWord >> bvh::kGeometryFlagShift & bvh::kGeometryDisableAnyHit) == 0;
}
SUNSTONE_INLINE bool droppedByFlags(uint32_t rayFlags, bool enabled) {
    return rayFlags & (enabled ? kRayCullEnforcedAnyHit : kRayCullDisabledAnyHit);
}
SUNSTONE_INLINE bool anyHitRuns(uint32_t rayFlags, bool enabled) {
    if (rayFlags & (kRayDisableAnyHit | kRayEnforceAnyHit))
        return (rayFlags & kRayDisableAnyHit) == 0;
    return enabled;
}

// Whether flags may drop hits of a structure of triangles, or any-hit programs run for them.
SUNSTONE_INLINE bool programsMayRun(const LaunchState& launch, uint32_t rayFlags,
                                    uint32_t instanceFlags, uint32_t geometryFlagsAnd) {
    if (rayFlags & (kRayCullDisabledAnyHit | kRayCullEnforcedAnyHit))
        return true;
    if (!launch.hasAnyHit || (rayFlags & kRayDisableAnyHit))
        return false;
    if (rayFlags & kRayEnforceAnyHit)
        return true;
    if (instanceFlags & (kInstanceDisableAnyHit | kInstanceEnforceAnyHit))
        return (instanceFlags & kInstanceDisableAnyHit) == 0;
    return (geometryFlagsAnd & bvh::kGeometryDisableAnyHit) == 0;
}

SUNSTONE_INLINE uint32_t triangleKind(float det, uint32_t instanceFlags) {
    const bool flipped = instanceFlags & kInstanceFlipFacing;
    return (det > 0) != flipped ? kHitTriangleFront : kHitTriangleBack;
}

// Of two built-in primitives at the same distance the one with the lower number is hit, in any
// order of the walk.
SUNSTONE_INLINE bool losesTie(float t, uint32_t primitive, bool found, float bestT,
                              uint32_t bestPrimitive) {
    return t == bestT && found && primitive > bestPrimitive;
}

// Whether t is in the ray's current interval.
SUNSTONE_INLINE bool inInterval(const RayState& ray, float t, float tmax) {
    return t >= ray.tmin && t <= tmax;
}

// Turns a hit of optixReportIntersection into the candidate.
template <class Records>
SUNSTONE_INLINE void reportCandidate(RayState& ray, float t, uint32_t kind) {
    ray.hit.t = t;
    ray.hit.kind = kind & 0x7F;
    if constexpr (!Records::kAttributeBlocks)
        for (unsigned i = 0; i < Records::kAttributeWords; ++i)
            ray.hit.attributes[i] = ray.reportAttributes[i];
}

// Turns the candidate into the best hit, except for its place in the graph.
template <class Records, class Best>
SUNSTONE_INLINE void keepCandidate(const Hit& hit, Best& best) {
    best.kind = hit.kind;
    best.primitive = hit.primitive;
    best.sbtGasIndex = hit.sbtGasIndex;
    for (unsigned i = 0; i < Records::kAttributeWords; ++i)
        best.attributes[i] = hit.attributes[i];
}

// Whether an accepted hit ends the ray. `result`: the any-hit program's.
SUNSTONE_INLINE bool endsRay(uint32_t result, uint32_t rayFlags) {
    return result == kTerminate || (rayFlags & kRayTerminateOnFirstHit);
}

// The bit of OptixPrimitiveTypeFlags that a structure's primitives have.
SUNSTONE_INLINE uint32_t primitiveFlagOf(const bvh::BlockHeader& block) {
    switch (bvh::kindOf(block.type)) {
    case bvh::BlockType::kTriangles:
        return 1u << 31;
    case bvh::BlockType::kCustom:
        return 1;
    case bvh::BlockType::kShapes:
        return 1u << (block.shape & 15);
    default:
        return ~0u;
    }
}

// The code of the exception that a traversable raises under debug exceptions, below `above` others;
// 0 if it fits the pipeline. `block`: the structure of the handle, or null if there is none.
SUNSTONE_INLINE int32_t faultOfTraversable(const LaunchState& launch, HandleTag tag,
                                           const bvh::BlockHeader* block, uint32_t above) {
    const uint32_t flags = launch.traversableGraphFlags; // 0: all graphs
    const bool isInstances = block && bvh::kindOf(block->type) == bvh::BlockType::kInstances;
    const bool moves =
        tag == kTagMatrixMotion || tag == kTagSrtMotion || (block && bvh::isMoving(block->type));
    if (moves && !launch.motion)
        return kExceptionInvalidTraversable;
    switch (tag) {
    case kTagGas:
        if (!block || isInstances)
            return kExceptionInvalidTraversable;
        if (above == 0 && flags != 0 && !(flags & kAllowSingleGas))
            return kExceptionUnsupportedSingleGas;
        return launch.primitiveTypeFlags & primitiveFlagOf(*block) ? 0
                                                                   : kExceptionUnsupportedPrimitive;
    case kTagIas: {
        const bool allowed = flags == 0 || (flags != kAllowSingleGas && above == 0);
        return isInstances && allowed ? 0 : kExceptionInvalidTraversable;
    }
    case kTagStatic:
    case kTagMatrixMotion:
    case kTagSrtMotion:
        return flags == 0 ? 0 : kExceptionInvalidTraversable;
    default:
        return kExceptionInvalidTraversable;
    }
}

} // namespace sunstone::devlib
