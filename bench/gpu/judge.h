// SPDX-License-Identifier: Apache-2.0
// Decides which of two different hits of a ray is right, by ray/triangle tests with 113 bits of
// precision, which suffices for vertices and rays of ordinary exponents.
#pragma once

#include "programs.h"
#include "world.h"

#include <nlohmann/json.hpp>

namespace bench {

// Distance along the ray to the plane of the triangle that was hit, perhaps of an instance; NaN
// where they are parallel.
double planeDistance(const World& world, const Ray& ray, const GpuHit& hit);

// Counts the differences of `ours` from `reference`, ray by ray; null: none. In worlds of plain
// triangles some of the differing rays are also judged: which side finds the hit, and which
// distance is closer to the exact one.
nlohmann::json compareHits(const World& world, const std::vector<Ray>& rays, RayQuery query,
                           const std::vector<GpuHit>& ours, const std::vector<GpuHit>& reference);

} // namespace bench
