// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "wavefront.h"

extern "C" __constant__ TraceParams params;

extern "C" __global__ void __raygen__extend() {
    const unsigned slot = params.order[optixGetLaunchIndex().x];
    const PathState& path = params.paths[slot];
    unsigned p0 = slot, p1 = 0;
    optixTrace(params.scene, path.origin, path.direction, 1e-3f, 1e10f, 0, 255,
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, p0, p1);
}
extern "C" __global__ void __raygen__shadow() {
    const unsigned slot = params.order[optixGetLaunchIndex().x];
    const HitInfo& hit = params.hits[slot];
    unsigned p0 = slot, p1 = 1;
    optixTrace(params.scene, hit.position, make_float3(0.6f, 0.8f, 0.0f), 1e-3f, 1e10f, 0, 255,
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, p0, p1);
    params.shadowed[slot] = p1;
}
extern "C" __global__ void __miss__extend() {
    params.hits[optixGetPayload_0()].material = -1;
}
extern "C" __global__ void __miss__shadow() {
    optixSetPayload_1(0);
}
extern "C" __global__ void __intersection__sphere() {
    const float4 s = reinterpret_cast<const ShapeData*>(optixGetSbtDataPointer())->sphere;
    const float3 o = optixGetWorldRayOrigin(), d = optixGetWorldRayDirection();
    const float3 f = make_float3(o.x - s.x, o.y - s.y, o.z - s.z);
    const float b = f.x * d.x + f.y * d.y + f.z * d.z,
                rest = b * b - (f.x * f.x + f.y * f.y + f.z * f.z - s.w * s.w);
    if (rest < 0)
        return;
    const float root = sqrtf(rest);
    if (!optixReportIntersection(-b - root, 0))
        optixReportIntersection(-b + root, 0);
}
extern "C" __global__ void __closesthit__store() {
    const ShapeData& shape = *reinterpret_cast<const ShapeData*>(optixGetSbtDataPointer());
    const float3 o = optixGetWorldRayOrigin(), d = optixGetWorldRayDirection();
    const float t = optixGetRayTmax();
    HitInfo& hit = params.hits[optixGetPayload_0()];
    hit.position = make_float3(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
    const float r = 1.0f / shape.sphere.w;
    hit.normal =
        make_float3((hit.position.x - shape.sphere.x) * r, (hit.position.y - shape.sphere.y) * r,
                    (hit.position.z - shape.sphere.z) * r);
    hit.material = shape.material;
}
