// SPDX-License-Identifier: Apache-2.0
// Rays of light_tracer_lamps.cu and light_tracer_eye.cu.
#pragma once

#include "light_tracer.h"
#include "tools.h"

extern "C" {
__constant__ TracerParams params;
}

DEVICE HallHit findHit(float3 origin, float3 direction) {
    HallHit hit;
    hit.isHit = 0;
    const unsigned long long address = reinterpret_cast<unsigned long long>(&hit);
    unsigned high = address >> 32, low = address & 0xffffffffu;
    optixTrace(params.hall, origin, direction, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, high, low);
    return hit;
}
DEVICE bool areVisible(float3 a, float3 b) {
    const float3 line = b - a;
    unsigned hidden = 1, unused = 0;
    optixTrace(params.hall, a, line, 1e-3f, 0.999f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hidden, unused);
    return hidden == 0;
}
