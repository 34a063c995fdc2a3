// SPDX-License-Identifier: Apache-2.0
// Traces a ray per launch index at spheres and stores the hits as programs see them.
#include "spheres.h"

#include "optix76/optix.h"

extern "C" __constant__ SphereParams params;

static __forceinline__ __device__ SphereResult& result() {
    return params.results[optixGetLaunchIndex().x];
}

extern "C" __global__ void __raygen__spheres() {
    const SphereRay& ray = params.rays[optixGetLaunchIndex().x];
    optixTrace(params.handle, make_float3(ray.origin[0], ray.origin[1], ray.origin[2]),
               make_float3(ray.direction[0], ray.direction[1], ray.direction[2]), ray.tmin,
               ray.tmax, params.time, OptixVisibilityMask(255), ray.flags, 0, 1, 0);
}

extern "C" __global__ void __miss__spheres() {
    ++result().misses;
}

extern "C" __global__ void __anyhit__spheres() {
    if (++result().anyHits <= params.ignore)
        optixIgnoreIntersection();
}

extern "C" __global__ void __closesthit__spheres() {
    SphereResult& r = result();
    ++r.closestHits;
    r.t = optixGetRayTmax();
    r.primitive = optixGetPrimitiveIndex();
    r.sbtGasIndex = optixGetSbtGASIndex();
    r.hitKind = optixGetHitKind();
    r.primitiveType = optixGetPrimitiveType();
    r.isFront = optixIsFrontFaceHit();
    r.isBack = optixIsBackFaceHit();
    r.isTriangle = optixIsTriangleHit();
    float4 data[1];
    optixGetSphereData(optixGetGASTraversableHandle(), r.primitive, r.sbtGasIndex, params.time,
                       data);
    r.data[0] = data[0].x;
    r.data[1] = data[0].y;
    r.data[2] = data[0].z;
    r.data[3] = data[0].w;
}
