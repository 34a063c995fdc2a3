// SPDX-License-Identifier: Apache-2.0
// A light without extent, for host and device.
#pragma once

#include <optixu/optixu_vector_types.h>

struct Light {
    optix::float3 position;
    optix::float3 color;
};
