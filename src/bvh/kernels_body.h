// SPDX-License-Identifier: Apache-2.0
// The functions of kernels.h, compiled once per instruction set.
#pragma once

#include "bvh/kernels.h"
#include "bvh/triangle_visitors.h"

namespace sunstone::bvh::SUNSTONE_ISA {

SUNSTONE_INLINE bool prepare(const void* block, const QueryRay& ray, RaySetup& setup) {
    const BlockHeader* header = headerOf(block);
    if (!looksLikeBlock(header) || header->type != BlockType::kTriangles ||
        !isRay(ray.origin, ray.direction, ray.tmin, ray.tmax))
        return false;
    setupRay(setup, header, ray.origin, ray.direction, ray.tmin, ray.tmax);
    return true;
}

static bool closest(const void* block, const QueryRay& ray, QueryHit& hit) {
    RaySetup setup;
    if (!prepare(block, ray, setup))
        return false;
    ClosestTriangle visitor(setup, ray.tmax, {});
    traverse(block, setup, visitor);
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

} // namespace sunstone::bvh::SUNSTONE_ISA
