// SPDX-License-Identifier: Apache-2.0
// Device programs of bench_launch: one launch index traces one ray of an array and stores its hit.
// The ray layout is that of the peer, so that both read the same bytes.
#include "launch_rays.h"

#include <optix.h>

extern "C" {
__constant__ LaunchRaysParams params;
}

static __forceinline__ __device__ unsigned int rayNumber() {
    const uint3 index = optixGetLaunchIndex();
    return index.x + index.y * optixGetLaunchDimensions().x;
}

extern "C" __global__ void __raygen__closest() {
    const unsigned int i = rayNumber();
    const BenchRay ray = params.rays[i];
    unsigned int t = __float_as_uint(-1.0f), primitive = ~0u;
    optixTrace(params.handle, make_float3(ray.ox, ray.oy, ray.oz), make_float3(ray.dx, ray.dy, ray.dz),
               ray.tmin, ray.tmax, params.shutter * timeOfRay(i), 255, OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, t, primitive);
    params.hits[i].t = __uint_as_float(t);
    params.hits[i].primitive = primitive;
}

extern "C" __global__ void __raygen__any() {
    const unsigned int i = rayNumber();
    const BenchRay ray = params.rays[i];
    unsigned int occluded = 1;
    optixTrace(params.handle, make_float3(ray.ox, ray.oy, ray.oz), make_float3(ray.dx, ray.dy, ray.dz),
               ray.tmin, ray.tmax, params.shutter * timeOfRay(i), 255,
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 0, occluded);
    params.hits[i].primitive = occluded;
}

extern "C" __global__ void __closesthit__store() {
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(optixGetPrimitiveIndex());
}

// One miss program serves both: payload 0 is "no distance" for closest hits and "not occluded" for
// any-hit rays, distinguished by the ray flags.
extern "C" __global__ void __miss__clear() {
    if (optixGetRayFlags() & OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT)
        optixSetPayload_0(0);
}
