// SPDX-License-Identifier: Apache-2.0
// Meshes of the fourth and the fifth set's scenes, in addition to ../third/shapes.h.
#pragma once

#include "../scene.h"
#include "../third/shapes.h"

#include <functional>

namespace bench {

// Adds triangles of one material, scaled and moved.
void append(MaterialMesh& mesh, const Mesh& other, float3 scale, float3 at, unsigned material);
// A grid of columns x rows cells over the unit square.
Mesh makeSheet(unsigned columns, unsigned rows, const std::function<float3(float, float)>& at);

} // namespace bench
