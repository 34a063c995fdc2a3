// SPDX-License-Identifier: Apache-2.0
// Traces a ray per launch index at curves and stores the hits as programs see them.
#include "curves.h"

#include "optix.h"

extern "C" __constant__ CurveParams params;

static __forceinline__ __device__ CurveResult& result() {
    return params.results[optixGetLaunchIndex().x];
}

extern "C" __global__ void __raygen__curves() {
    const CurveRay& ray = params.rays[optixGetLaunchIndex().x];
    optixTrace(params.handle, make_float3(ray.origin[0], ray.origin[1], ray.origin[2]),
               make_float3(ray.direction[0], ray.direction[1], ray.direction[2]), ray.tmin,
               ray.tmax, params.time, OptixVisibilityMask(255), ray.flags, 0, 1, 0);
}

extern "C" __global__ void __miss__curves() {
    ++result().misses;
}

extern "C" __global__ void __anyhit__curves() {
    CurveResult& r = result();
    ++r.anyHits;
    r.anyHitT = optixGetRayTmax();
    r.anyHitU = optixGetCurveParameter();
    r.anyHitTmax = optixGetRayTmax();
    if (params.rule == kCurveIgnore || (params.rule == kCurveIgnoreFirstTwo && r.anyHits <= 2))
        optixIgnoreIntersection();
    if (params.rule == kCurveTerminate)
        optixTerminateRay();
}

static __forceinline__ __device__ void write(CurveResult& r, const float4* data, unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
        r.points[4 * i] = data[i].x;
        r.points[4 * i + 1] = data[i].y;
        r.points[4 * i + 2] = data[i].z;
        r.points[4 * i + 3] = data[i].w;
    }
}

extern "C" __global__ void __closesthit__curves() {
    CurveResult& r = result();
    ++r.closestHits;
    r.t = optixGetRayTmax();
    r.u = optixGetCurveParameter();
    r.primitive = optixGetPrimitiveIndex();
    r.sbtGasIndex = optixGetSbtGASIndex();
    r.hitKind = optixGetHitKind();
    r.primitiveType = optixGetPrimitiveType();
    r.isFront = optixIsFrontFaceHit();
    r.isBack = optixIsBackFaceHit();
    r.isTriangle = optixIsTriangleHit();
    const OptixTraversableHandle gas = optixGetGASTraversableHandle();
    float4 data[4];
    switch (r.primitiveType) {
    case OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR:
        optixGetLinearCurveVertexData(gas, r.primitive, r.sbtGasIndex, params.time, data);
        write(r, data, 2);
        break;
    case OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE:
        optixGetQuadraticBSplineVertexData(gas, r.primitive, r.sbtGasIndex, params.time, data);
        write(r, data, 3);
        break;
    case OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE:
        optixGetCubicBSplineVertexData(gas, r.primitive, r.sbtGasIndex, params.time, data);
        write(r, data, 4);
        break;
    case OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM:
        optixGetCatmullRomVertexData(gas, r.primitive, r.sbtGasIndex, params.time, data);
        write(r, data, 4);
        break;
    default:
        break;
    }
}
