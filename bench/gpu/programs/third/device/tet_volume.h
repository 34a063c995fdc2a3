// SPDX-License-Identifier: Apache-2.0
// Launch parameters of tet_volume.cu.
#pragma once

#include "camera.h"

#include <optix.h>

struct TetParams {
    float4* image;
    OptixTraversableHandle faces;
    const int2* sides; // the tetrahedra in front of and behind a face, or -1
    const uint4* tetrahedra;
    const float4* points; // place and value
    Camera camera;
    int steps;
};
