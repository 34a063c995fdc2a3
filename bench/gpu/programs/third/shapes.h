// SPDX-License-Identifier: Apache-2.0
// Meshes of the scenes of the third and the later sets.
#pragma once

#include "../../../scenes.h"

#include "vec.h"

#include <vector>

namespace bench {

// Adds the triangles of `other`, scaled and moved.
void append(Mesh& mesh, const Mesh& other, float3 scale, float3 at);
// Twelve triangles whose normals point outwards.
Mesh makeBox(float3 low, float3 high);
// A body of revolution around the y axis. The profile has radii (x) and heights (y), the lowest
// first. `teeth`: of a gear, 0: round.
Mesh makeLathe(const std::vector<float2>& profile, unsigned sectors, unsigned teeth = 0);
// A row-major 3x4 matrix: scales, turns around y, then moves.
struct Placement {
    float matrix[12];
};
Placement placed(float3 at, float scale, float turns);
// A unit vector for each vertex: the mean of its triangles.
std::vector<float3> smoothNormals(const Mesh& mesh);

} // namespace bench
