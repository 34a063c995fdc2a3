// SPDX-License-Identifier: Apache-2.0
// Which of two answers to the same ray is right: rays against triangles in arithmetic of 113 bits,
// enough for vertices and rays of ordinary exponents that its rounding does not matter.
#pragma once

#include "programs.h"
#include "world.h"

#include <nlohmann/json.hpp>

namespace bench {

// Distance along the ray to the plane of the triangle that was hit, perhaps of an instance; NaN
// where they are parallel.
double planeDistance(const World& world, const Ray& ray, const GpuHit& hit);

// Counts how `ours` differs from `reference`, ray by ray; null: not at all. In worlds of plain
// triangles some of the differing rays are also judged: who finds what there is, whose distance is
// nearer.
nlohmann::json compareHits(const World& world, const std::vector<Ray>& rays, RayQuery query,
                           const std::vector<GpuHit>& ours, const std::vector<GpuHit>& reference);

} // namespace bench
