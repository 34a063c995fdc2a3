// SPDX-License-Identifier: Apache-2.0
// Data that the passes of the sample exchange, for host and device.
#pragma once

#include <optixu/optixu_vector_types.h>

struct Photon {
    optix::float3 place;
    optix::float3 normal; // of the surface; zero: nothing was hit
    optix::float3 direction;
    optix::float3 power;
    int axis; // of the tree's plane through the photon; kLeafAxis: no children
};
enum { kLeafAxis = 3 };

// What the camera sees in a pixel, and the photons that arrived so far.
struct Seen {
    optix::float3 place;
    optix::float3 normal;
    optix::float3 weight; // of light that leaves the place towards the eye
    optix::float3 direct; // light that needs no photons
    float radius2;
    float count;
    optix::float3 flux;
    int surface; // 0: none
};
