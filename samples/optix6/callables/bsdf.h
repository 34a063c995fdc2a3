// SPDX-License-Identifier: Apache-2.0
// Results of the callable programs of materials and lights.
#pragma once

#include <optix_world.h>

struct BsdfSample {
    optix::float3 direction; // in the surface's frame, z is the normal
    optix::float3 weight;
    float diffuse; // share of light from everywhere that the surface scatters
};

struct LightSample {
    optix::float3 direction;
    optix::float3 radiance; // at the point
    float distance;
};
