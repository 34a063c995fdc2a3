// SPDX-License-Identifier: Apache-2.0
// Device programs of bench_gpu: one launch index traces one ray of an array and stores its hit.
// With BENCH_INSTANCES a third payload value carries the instance; with BENCH_MOTION rays have
// times.
#include "programs.h"

#include <optix.h>

extern "C" {
__constant__ GpuRaysParams params;
}

static __forceinline__ __device__ float timeOf(unsigned int ray) {
#ifdef BENCH_MOTION
    return params.times[ray];
#else
    return 0.0f;
#endif
}

static __forceinline__ __device__ void closest(unsigned int flags) {
    const unsigned int i = optixGetLaunchIndex().x;
    const GpuRay ray = params.rays[i];
    unsigned int t = __float_as_uint(-1.0f), primitive = ~0u;
    optixTrace(params.handle, make_float3(ray.ox, ray.oy, ray.oz),
               make_float3(ray.dx, ray.dy, ray.dz), ray.tmin, ray.tmax, timeOf(i), 255, flags, 0, 1,
               0, t, primitive);
    params.hits[i].t = __uint_as_float(t);
    params.hits[i].primitive = primitive;
}

static __forceinline__ __device__ void any(unsigned int flags) {
    const unsigned int i = optixGetLaunchIndex().x;
    const GpuRay ray = params.rays[i];
    unsigned int occluded = 1;
    optixTrace(params.handle, make_float3(ray.ox, ray.oy, ray.oz),
               make_float3(ray.dx, ray.dy, ray.dz), ray.tmin, ray.tmax, timeOf(i), 255,
               flags | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 0,
               1, 0, occluded);
    params.hits[i].primitive = occluded;
}

extern "C" __global__ void __raygen__closest() {
    closest(OPTIX_RAY_FLAG_DISABLE_ANYHIT);
}
extern "C" __global__ void __raygen__any() {
    any(OPTIX_RAY_FLAG_DISABLE_ANYHIT);
}
extern "C" __global__ void __raygen__closest_cutout() {
    closest(OPTIX_RAY_FLAG_NONE);
}
extern "C" __global__ void __raygen__any_cutout() {
    any(OPTIX_RAY_FLAG_NONE);
}

#ifdef BENCH_INSTANCES
extern "C" __global__ void __raygen__closest_instance() {
    const unsigned int i = optixGetLaunchIndex().x;
    const GpuRay ray = params.rays[i];
    unsigned int t = __float_as_uint(-1.0f), primitive = ~0u, instance = ~0u;
    optixTrace(params.handle, make_float3(ray.ox, ray.oy, ray.oz),
               make_float3(ray.dx, ray.dy, ray.dz), ray.tmin, ray.tmax, timeOf(i), 255,
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, t, primitive, instance);
    params.hits[i].t = __uint_as_float(t);
    params.hits[i].primitive = primitive;
    params.hits[i].instance = instance;
}

extern "C" __global__ void __closesthit__store_instance() {
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(optixGetPrimitiveIndex());
    optixSetPayload_2(optixGetInstanceIndex());
}
#endif

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

// A leaf's pair of triangles is a square with a checkered disc, which covers nearly a third of its
// area.
extern "C" __global__ void __anyhit__cutout() {
    const float2 b = optixGetTriangleBarycentrics();
    // Triangle 0 has the corners (0, 0), (1, 0), (1, 1), triangle 1 (0, 0), (1, 1), (0, 1).
    const bool second = optixGetPrimitiveIndex() & 1;
    const float u = second ? b.x : b.x + b.y;
    const float v = second ? b.x + b.y : b.y;
    const float x = u - 0.5f, y = v - 0.5f;
    const int square = int(u * 6.0f) + int(v * 6.0f);
    if (x * x + y * y > 0.25f || square % 2 == 1)
        optixIgnoreIntersection();
}

extern "C" __global__ void __intersection__sphere() {
    const float* sphere = params.spheres + 4 * size_t(optixGetPrimitiveIndex());
    const float3 o = optixGetWorldRayOrigin(), d = optixGetWorldRayDirection();
    const float x = o.x - sphere[0], y = o.y - sphere[1], z = o.z - sphere[2];
    const float a = d.x * d.x + d.y * d.y + d.z * d.z;
    const float b = (x * d.x + y * d.y + z * d.z) / a;
    // Squared distance of the centre from the line.
    const float px = x - b * d.x, py = y - b * d.y, pz = z - b * d.z;
    const float root = sphere[3] * sphere[3] - (px * px + py * py + pz * pz);
    if (root < 0.0f)
        return;
    const float half = sqrtf(root / a);
    const float enter = -b - half;
    optixReportIntersection(enter > optixGetRayTmin() ? enter : -b + half, 0);
}
