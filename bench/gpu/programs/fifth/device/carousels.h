// SPDX-License-Identifier: Apache-2.0
// Launch parameters and records of carousels.cu.
#pragma once

#include "../../third/device/mesh.h"
#include "camera.h"

#include <optix.h>

struct CarouselParams {
    float4* image;
    OptixTraversableHandle fair;
    Camera camera;
    float3 sun;
    unsigned samples, bounces;
};

struct CarouselRecord {
    MeshView mesh; // of triangles
    float3 color;
    float glow, mirror; // light of its own; the share of mirrored light
};
