// SPDX-License-Identifier: Apache-2.0
// Launches that only trace: rays and hits are in device memory. Payload: distance, barycentrics,
// triangle; for shadow rays one word.
#include "tools.h"
#include "wavefront.h"

extern "C" {
__constant__ WaveParams params;
}

extern "C" __global__ void __raygen__closest() {
    const unsigned i = optixGetLaunchIndex().x;
    const QueuedRay ray = params.rays[i];
    unsigned t = __float_as_uint(-1.0f), u = 0, v = 0, triangle = 0;
    optixTrace(params.handle, ray.origin, ray.direction, ray.tmin, ray.tmax, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, 0, t, u, v, triangle);
    QueuedHit hit;
    hit.t = __uint_as_float(t);
    hit.u = __uint_as_float(u);
    hit.v = __uint_as_float(v);
    hit.triangle = triangle;
    params.hits[i] = hit;
}

extern "C" __global__ void __closesthit__store() {
    const float2 b = optixGetTriangleBarycentrics();
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(__float_as_uint(b.x));
    optixSetPayload_2(__float_as_uint(b.y));
    optixSetPayload_3(optixGetPrimitiveIndex());
}

extern "C" __global__ void __raygen__shadow() {
    const unsigned i = optixGetLaunchIndex().x;
    const QueuedRay ray = params.shadowRays[i];
    unsigned isFree = 0, unused = 0;
    optixTrace(params.handle, ray.origin, ray.direction, ray.tmin, ray.tmax, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 0, 1, isFree, unused, unused, unused);
    if (!isFree)
        return;
    // A pixel has one path, so no two threads add to it.
    const QueuedLight light = params.lights[i];
    float4 pixel = params.image[light.pixel];
    pixel.x += light.light.x;
    pixel.y += light.light.y;
    pixel.z += light.light.z;
    params.image[light.pixel] = pixel;
}

extern "C" __global__ void __miss__closest() {}
extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(1);
}
