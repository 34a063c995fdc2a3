// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "random_graphs.h"

extern "C" __constant__ Params params;

static __forceinline__ __device__ Answer& answer() {
    return params.answers[optixGetLaunchIndex().x];
}

extern "C" __global__ void __raygen__probe() {
    const Ray ray = params.rays[optixGetLaunchIndex().x];
    answer() = Answer{};
    optixTrace(params.scene, ray.origin, ray.direction, 0.0f, 1e16f, ray.time, ray.mask,
               OPTIX_RAY_FLAG_NONE, 1, 2, 0);
}

extern "C" __global__ void __miss__probe() {
    answer().t = -1.0f;
}

extern "C" __global__ void __anyhit__probe() {
    ++answer().filtered;
}

// Squares of size 1 at the heights 0, 0.3, 0.6 and so on.
extern "C" __global__ void __intersection__square() {
    const float3 o = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    const unsigned number = optixGetPrimitiveIndex();
    const float t = (0.3f * float(number) - o.z) / d.z;
    if (fabsf(o.x + t * d.x) < 0.5f && fabsf(o.y + t * d.y) < 0.5f)
        optixReportIntersection(t, number + 1, __float_as_uint(o.x), __float_as_uint(o.y),
                                __float_as_uint(o.z));
}

static __device__ float3 times(const float4* m, float3 p) {
    return make_float3(m[0].x * p.x + m[0].y * p.y + m[0].z * p.z + m[0].w,
                       m[1].x * p.x + m[1].y * p.y + m[1].z * p.z + m[1].w,
                       m[2].x * p.x + m[2].y * p.y + m[2].z * p.z + m[2].w);
}

static __device__ float3 throughTransform(OptixTraversableHandle handle, float3 point) {
    float4 rows[3];
    switch (optixGetTransformTypeFromHandle(handle)) {
    case OPTIX_TRANSFORM_TYPE_INSTANCE:
        return times(optixGetInstanceTransformFromHandle(handle), point);
    case OPTIX_TRANSFORM_TYPE_STATIC_TRANSFORM: {
        const float* m = optixGetStaticTransformFromHandle(handle)->transform;
        for (int r = 0; r < 3; ++r)
            rows[r] = make_float4(m[4 * r], m[4 * r + 1], m[4 * r + 2], m[4 * r + 3]);
        break;
    }
    default:
        optix_impl::optixGetInterpolatedTransformationFromHandle(rows[0], rows[1], rows[2], handle,
                                                                 optixGetRayTime(), true);
    }
    return times(rows, point);
}

extern "C" __global__ void __closesthit__probe() {
    Answer& to = answer();
    to.t = optixGetRayTmax();
    to.primitive = optixGetPrimitiveIndex();
    to.id = optixGetInstanceId();
    to.index = optixGetInstanceIndex();
    to.record = *reinterpret_cast<const unsigned*>(optixGetSbtDataPointer());
    to.kind = optixGetHitKind();
    const unsigned length = optixGetTransformListSize();
    for (unsigned i = 0; i < length; ++i)
        to.path =
            to.path * 8 + unsigned(optixGetTransformTypeFromHandle(optixGetTransformListHandle(i)));
    const float3 marker = make_float3(1, 2, 3);
    to.point = optixTransformPointFromObjectToWorldSpace(marker);
    to.normal = optixTransformNormalFromObjectToWorldSpace(marker);
    to.origin = optixTransformPointFromWorldToObjectSpace(optixGetWorldRayOrigin());
    to.byHand = marker;
    for (unsigned i = length; i-- > 0;)
        to.byHand = throughTransform(optixGetTransformListHandle(i), to.byHand);
    if (!optixIsTriangleHit())
        to.tested = make_float3(__uint_as_float(optixGetAttribute_0()),
                                __uint_as_float(optixGetAttribute_1()),
                                __uint_as_float(optixGetAttribute_2()));
}
