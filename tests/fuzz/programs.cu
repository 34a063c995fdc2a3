// SPDX-License-Identifier: Apache-2.0
// Programs of every kind for the API fuzzer. With any launch parameters they write only into
// `answers`.
#include <optix.h>

#include "programs.h"

extern "C" {
__constant__ FuzzParams params;
}

static __forceinline__ __device__ void answer(unsigned value) {
    const uint3 index = optixGetLaunchIndex();
    const unsigned i = index.x + optixGetLaunchDimensions().x * index.y;
    if (params.answers && i < params.count)
        params.answers[i] = value;
}

extern "C" __global__ void __raygen__trace() {
    unsigned payload = optixGetLaunchIndex().x;
    const float shift = optixGetLaunchIndex().x * 0.01f;
    optixTrace(params.handle, make_float3(params.origin[0] + shift, params.origin[1], params.origin[2]),
               make_float3(params.direction[0], params.direction[1], params.direction[2]), params.tmin,
               params.tmax, params.time, params.mask, params.rayFlags, params.sbtOffset,
               params.sbtStride, params.missIndex, payload);
    answer(payload);
}

extern "C" __global__ void __raygen__call() {
    answer(optixDirectCall<unsigned, unsigned>(params.callable, 3u) +
           optixContinuationCall<unsigned, unsigned>(params.callable + 1, 4u));
}

extern "C" __global__ void __raygen__throw() {
    if (optixGetLaunchIndex().x % 3 == 0)
        optixThrowException(int(params.callable & 0xffff), 1, 2);
    answer(7);
}

extern "C" __device__ unsigned __direct_callable__add(unsigned a) { return a + 1; }
extern "C" __device__ unsigned __continuation_callable__add(unsigned a) { return a * 2; }
extern "C" __global__ void __exception__note() { answer(unsigned(optixGetExceptionCode())); }
extern "C" __global__ void __miss__note() { optixSetPayload_0(1u); }

// Points of the primitive that was hit, if the structure gives them; sometimes of another.
static __forceinline__ __device__ float readPoints() {
    const OptixTraversableHandle gas = optixGetGASTraversableHandle();
    const unsigned primitive = optixGetPrimitiveIndex() + (params.callable & 1);
    const unsigned record = optixGetSbtGASIndex() + (params.callable & 2);
    float3 corners[3];
    float4 points[4];
    switch (optixGetPrimitiveType()) {
    case OPTIX_PRIMITIVE_TYPE_TRIANGLE:
        optixGetTriangleVertexData(gas, primitive, record, params.time, corners);
        return corners[2].x;
    case OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR:
        optixGetLinearCurveVertexData(gas, primitive, record, params.time, points);
        return points[1].w;
    case OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM:
        optixGetCatmullRomVertexData(gas, primitive, record, params.time, points);
        return points[3].w;
    default:
        return 0.0f;
    }
}

// Any handle, of the wrong kind as a rule.
static __forceinline__ __device__ unsigned readHandle(OptixTraversableHandle handle) {
    return optixGetGASMotionStepCount(handle) +
           unsigned(optixGetInstanceTraversableFromIAS(handle, params.callable & 7));
}

// Reads all properties of a hit.
extern "C" __global__ void __closesthit__note() {
    unsigned sum = optixGetPrimitiveIndex() + optixGetInstanceIndex() + optixGetInstanceId() +
                   optixGetHitKind() + optixGetSbtGASIndex() + optixGetTransformListSize();
    for (unsigned i = 0; i < optixGetTransformListSize(); ++i)
        sum += unsigned(optixGetTransformTypeFromHandle(optixGetTransformListHandle(i)));
    const float3 p = optixTransformPointFromWorldToObjectSpace(optixGetWorldRayOrigin());
    sum += unsigned(p.x > 0.0f);
    if (optixIsTriangleHit())
        sum += unsigned(optixGetTriangleBarycentrics().x > 0.5f);
    optixSetPayload_0(sum + unsigned(readPoints() > 0.0f) + readHandle(params.handle));
}

extern "C" __global__ void __anyhit__note() {
    if (optixGetObjectRayDirection().x > 2.0f)
        optixSetPayload_1(unsigned(optixGetRayTmax()));
    if (optixGetPrimitiveIndex() % 5 == 1)
        optixIgnoreIntersection();
    if (optixGetPrimitiveIndex() % 7 == 2)
        optixTerminateRay();
}

extern "C" __global__ void __intersection__note() {
    optixReportIntersection(optixGetRayTmin() + 0.5f, optixGetPrimitiveIndex() & 63, 1u, 2u);
    optixReportIntersection(optixGetRayTmax() * 0.5f, 200u);
}
