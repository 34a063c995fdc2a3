// SPDX-License-Identifier: Apache-2.0
// Records of the buffers of light_baking.cpp.
#pragma once

#include <optixu/optixu_math_namespace.h>

struct BakePoint {
    optix::float3 position, normal;
    float open; // the part of the sky that is seen
    int hits;
    unsigned id;
    unsigned char padding[5];
};

struct BakeBall {
    optix::float3 center;
    float radius;
};
