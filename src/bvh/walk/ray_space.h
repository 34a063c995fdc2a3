// SPDX-License-Identifier: Apache-2.0
// A space in which the ray starts at zero and is the z axis: distances from the ray are lengths in
// x and y, and z is the distance along it. Included by files compiled once per instruction set.
#pragma once

#include "bvh/lanes.h"
#include "bvh/scalars.h"

namespace sunstone::bvh::SUNSTONE_ISA {

#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpsabi"

struct RaySpace {
    float origin[3];
    float x[3], y[3], z[3]; // orthonormal; z is the direction
    float length;           // of the ray's direction: z = t * length
    float toT;              // 1 / length
    float tmin;
};

// False where the direction is too long for a number.
SUNSTONE_INLINE bool setupRaySpace(RaySpace& s, const float origin[3], const float d[3],
                                   float tmin) {
    const float longest = larger(larger(absolute(d[0]), absolute(d[1])), absolute(d[2]));
    const float a[3] = {d[0] / longest, d[1] / longest, d[2] / longest};
    const float scaled = __builtin_sqrtf(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    s.length = longest * scaled;
    s.toT = 1 / s.length;
    if (!finite(s.length))
        return false;
    const float zx = a[0] / scaled, zy = a[1] / scaled, zz = a[2] / scaled;
    // An orthonormal basis without a special case: Duff et al., "Building an Orthonormal Basis,
    // Revisited", JCGT 2017.
    const float sign = __builtin_copysignf(1.0f, zz);
    const float p = -1 / (sign + zz), q = zx * zy * p;
    const float x[3] = {1 + sign * zx * zx * p, sign * q, -sign * zx};
    const float y[3] = {q, sign + zy * zy * p, -zy};
    for (int i = 0; i < 3; ++i) {
        s.origin[i] = origin[i];
        s.x[i] = x[i];
        s.y[i] = y[i];
    }
    s.z[0] = zx, s.z[1] = zy, s.z[2] = zz;
    s.tmin = tmin;
    return true;
}

// Points of a leaf, one in each lane.
template <class V>
struct Point {
    V x, y, z;
};

template <class V>
SUNSTONE_INLINE Point<V> toRaySpace(const RaySpace& s, V px, V py, V pz) {
    const V x = px - s.origin[0], y = py - s.origin[1], z = pz - s.origin[2];
    const auto along = [&](const float axis[3]) {
        return fused(all<V>(axis[0]), x, fused(all<V>(axis[1]), y, axis[2] * z));
    };
    return {along(s.x), along(s.y), along(s.z)};
}

// One point and a fourth number that stays unchanged.
SUNSTONE_INLINE V4 toRaySpace(const RaySpace& s, V4 point) {
    const V4 p = point - V4{s.origin[0], s.origin[1], s.origin[2], 0};
    const V4 x = {s.x[0], s.y[0], s.z[0], 0}, y = {s.x[1], s.y[1], s.z[1], 0},
             z = {s.x[2], s.y[2], s.z[2], 0}, w = {0, 0, 0, 1};
    return fused(all<V4>(p[0]), x, fused(all<V4>(p[1]), y, fused(all<V4>(p[2]), z, p[3] * w)));
}

#pragma clang diagnostic pop

} // namespace sunstone::bvh::SUNSTONE_ISA
