// SPDX-License-Identifier: Apache-2.0
// Triangles in records and launch parameters of the third and the later sets.
#pragma once

#include "vec.h"

struct MeshView {
    const float3* vertices;
    const uint3* indices;

    // The normal of a triangle, of any length.
    SAMPLE_INLINE float3 normal(unsigned triangle) const {
        const uint3 t = indices[triangle];
        const float3 a = vertices[t.x];
        return cross(vertices[t.y] - a, vertices[t.z] - a);
    }
};
