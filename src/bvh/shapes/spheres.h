// SPDX-License-Identifier: Apache-2.0
// Spheres in acceleration structures. A block of spheres holds two arrays before the nodes,
//   points   float4 per sphere (centre, radius), with motion at each key in turn
//   records  ShapeRecord per sphere
// and leaves of up to N spheres: rows of N words, row 0 the sphere's number (kNoSphere: unused
// lane), rows 1 to 4 centre and radius (NaN where the sphere is inactive or the lane unused). With
// motion, rows 1 to 4 follow for each later key.
//
// A hit is where the ray enters the sphere, at its front, or where it leaves the sphere if the ray
// starts inside.
#pragma once

#include "base/inline.h"
#include "bvh/layout.h"

namespace sunstone::bvh {

constexpr uint32_t kSphereShape = 0x2506; // the OptixPrimitiveType
constexpr uint32_t kSphereRows = 5;
constexpr uint32_t kNoSphere = ~0u;

SUNSTONE_INLINE constexpr uint32_t sphereLeafBytes(uint32_t lanes, uint32_t keys) {
    const uint32_t rows = kSphereRows + (keys - 1) * (kSphereRows - 1);
    return (rows * lanes * 4 + kRefUnit - 1) / kRefUnit * kRefUnit;
}

} // namespace sunstone::bvh
