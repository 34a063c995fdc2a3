// SPDX-License-Identifier: Apache-2.0
// Data that the recursive ray tracer of bench_gpu shares with its device programs.
#pragma once

#include <cuda_runtime.h>

struct RecursionParams {
    float4* image;
    const float3* vertices;
    const uint3* triangles;
    unsigned long long handle;
    float3 eye, forward, right, up; // the camera: right and up to the edges of the picture
    float3 sun;                     // direction, unit
    float epsilon;
    unsigned int samples;
    unsigned int depth; // of rays from the camera on
};
