// SPDX-License-Identifier: Apache-2.0
// Rays against spheres, four or eight at a time, in the space of the ray. Compiled once per
// instruction set.
#pragma once

#include "bvh/shapes/spheres.h"
#include "bvh/walk/ray_space.h"

namespace sunstone::bvh::SUNSTONE_ISA {

#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpsabi"

template <class V>
struct SphereHits {
    V enter, leave;   // as t
    Mask in, out;     // which of them are within the interval
};

template <unsigned N>
SUNSTONE_INLINE SphereHits<Lanes<N>> testSpheres(const float* rows, const RaySpace& s,
                                                 float tmax) {
    using V = Lanes<N>;
    const auto row = [&](int i) { return loadLanes<V>(rows + i * int(N)); };
    const Point<V> p = toRaySpace(s, row(0), row(1), row(2));
    const V r = row(3), square = fused(r, r, -fused(p.x, p.x, p.y * p.y));
    const V half = rootOrZero(square);
    SphereHits<V> out;
    out.enter = (p.z - half) * s.toT;
    out.leave = (p.z + half) * s.toT;
    const auto meets = square >= 0.0f;
    out.in = bitsOfMask(meets & (out.enter >= s.tmin) & (out.enter <= tmax));
    out.out = bitsOfMask(meets & (out.leave >= s.tmin) & (out.leave <= tmax));
    return out;
}

#pragma clang diagnostic pop

} // namespace sunstone::bvh::SUNSTONE_ISA
