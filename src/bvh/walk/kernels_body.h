// SPDX-License-Identifier: Apache-2.0
// The functions of kernels.h, compiled once per instruction set.
#pragma once

#include "bvh/motion/motion_traverse.h"
#include "bvh/walk/kernels.h"
#include "bvh/walk/triangle_visitors.h"

namespace sunstone::bvh::SUNSTONE_ISA {

SUNSTONE_INLINE bool prepare(const void* block, const QueryRay& ray, RaySetup& setup,
                             BlockType type = BlockType::kTriangles) {
    const BlockHeader* header = headerOf(block);
    if (!looksLikeBlock(header) || header->type != type ||
        !isRay(ray.origin, ray.direction, ray.tmin, ray.tmax))
        return false;
    setupRay(setup, header, ray.origin, ray.direction, ray.tmin, ray.tmax);
    return true;
}

SUNSTONE_INLINE bool describe(const ClosestTriangle& visitor, QueryHit& hit) {
    if (!visitor.found)
        return false;
    hit.t = visitor.tmax;
    hit.u = visitor.v / visitor.det;
    hit.v = visitor.w / visitor.det;
    hit.primitive = visitor.primitive;
    hit.sbt = visitor.sbt;
    hit.front = visitor.det > 0;
    return true;
}

static bool closest(const void* block, const QueryRay& ray, QueryHit& hit) {
    RaySetup setup;
    if (!prepare(block, ray, setup))
        return false;
    ClosestTriangle visitor(setup, ray.tmax, {});
    traverse(block, setup, visitor);
    return describe(visitor, hit);
}

static bool occluded(const void* block, const QueryRay& ray) {
    RaySetup setup;
    if (!prepare(block, ray, setup))
        return false;
    AnyTriangle visitor(setup, ray.tmax, {});
    traverse(block, setup, visitor);
    return visitor.found;
}

static bool meetsSide(const void* block, const QueryRay& ray, bool front) {
    RaySetup setup;
    if (!prepare(block, ray, setup))
        return false;
    AnyTriangle visitor(setup, ray.tmax, {!front, front});
    traverse(block, setup, visitor);
    return visitor.found;
}

// Whether the structure can be hit at the time; if so, computes the keys of that time.
SUNSTONE_INLINE bool prepareAt(const void* block, const QueryRay& ray, float time, RaySetup& setup,
                               KeySegment& at) {
    if (!prepare(block, ray, setup, withMotion(BlockType::kTriangles)))
        return false;
    const BlockHeader& header = *headerOf(block);
    at = keySegment(header, time);
    return !hasVanished(header.motionFlags, header.motionBegin, header.motionEnd, time);
}

static bool closestAt(const void* block, const QueryRay& ray, float time, QueryHit& hit) {
    RaySetup setup;
    KeySegment at;
    if (!prepareAt(block, ray, time, setup, at))
        return false;
    Moving<ClosestTriangle> visitor(at, setup, ray.tmax, Culling{});
    traverseNodes(block, MovingNodes(*headerOf(block), setup, at), visitor);
    return describe(visitor, hit);
}

static bool occludedAt(const void* block, const QueryRay& ray, float time) {
    RaySetup setup;
    KeySegment at;
    if (!prepareAt(block, ray, time, setup, at))
        return false;
    Moving<AnyTriangle> visitor(at, setup, ray.tmax, Culling{});
    traverseNodes(block, MovingNodes(*headerOf(block), setup, at), visitor);
    return visitor.found;
}

static constexpr Kernels kAllKernels = {closest, occluded, meetsSide, closestAt, occludedAt};

} // namespace sunstone::bvh::SUNSTONE_ISA
