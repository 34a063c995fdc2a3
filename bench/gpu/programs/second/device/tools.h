// SPDX-License-Identifier: Apache-2.0
// Functions that device programs of the second and the later sets share.
#pragma once

#include "camera.h"
#include "sampling.h"

#include <optix.h>

#define DEVICE static __forceinline__ __device__

DEVICE float nextFloat(unsigned& state) {
    const unsigned bits = hashPcg(state);
    state = state * 747796405u + 2891336453u;
    return float(bits >> 8) * (1.0f / 16777216.0f);
}
DEVICE float3 blueSky(float3 direction) {
    return lerp(vec(0.95f, 0.9f, 0.85f), vec(0.25f, 0.48f, 0.9f), 0.5f + 0.5f * direction.y);
}
DEVICE float3 rayPoint() {
    return optixGetWorldRayOrigin() + optixGetWorldRayDirection() * optixGetRayTmax();
}
DEVICE float3 towardsRay(float3 normal) {
    return dot(normal, optixGetWorldRayDirection()) > 0.0f ? -normal : normal;
}
DEVICE float4 withWeight(float3 color, float weight) {
    return make_float4(color.x, color.y, color.z, weight);
}
