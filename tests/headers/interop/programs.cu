// SPDX-License-Identifier: Apache-2.0
// Device side of the interop test: stores the results of the device functions. See interop.cpp.
#include <optix.h>

#include "scene.h"

extern "C" {
__constant__ Params params;
}

static __device__ float3 load(const float* f) {
    return make_float3(f[0], f[1], f[2]);
}

static __device__ void store(float* to, float3 from) {
    to[0] = from.x;
    to[1] = from.y;
    to[2] = from.z;
}

extern "C" __global__ void __raygen__interop() {
    Result& result = *params.result;
    if (params.mode == kModeThrow) {
        optixThrowException(77, 1234u, 5678u);
        return;
    }
    unsigned int p[32];
    for (unsigned int i = 0; i < 32; ++i)
        p[i] = 100 + i;
    optixTrace(params.handle, load(params.origin), load(params.direction), 0.0f, 1e16f, params.time,
               OptixVisibilityMask(0xFF), OPTIX_RAY_FLAG_NONE, 0, 1, 0, p[0], p[1], p[2], p[3],
               p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12], p[13], p[14], p[15], p[16],
               p[17], p[18], p[19], p[20], p[21], p[22], p[23], p[24], p[25], p[26], p[27], p[28],
               p[29], p[30], p[31]);
    for (unsigned int i = 0; i < 32; ++i)
        result.payload[i] = p[i];
    result.called = optixDirectCall<float, float, int>(0, 2.5f, 4);
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    result.sbtData = *(const unsigned int*)optixGetSbtDataPointer() + index.x + size.y * size.z - 1;
}

extern "C" __device__ float __direct_callable__interop(float a, int b) {
    return a * (float)b + 0.5f;
}

extern "C" __global__ void __miss__interop() {
    params.result->misses += 1;
}

extern "C" __global__ void __anyhit__interop() {
    Result& result = *params.result;
    store(result.rayObject, optixGetObjectRayOrigin());
    store(result.rayObject + 3, optixGetObjectRayDirection());
    store(result.rayComputed, optixTransformPointFromWorldToObjectSpace(optixGetWorldRayOrigin()));
    store(result.rayComputed + 3,
          optixTransformVectorFromWorldToObjectSpace(optixGetWorldRayDirection()));
}

extern "C" __global__ void __closesthit__interop() {
    Result& result = *params.result;
    result.hits += 1;
    result.t = optixGetRayTmax();
    const float2 barycentrics = optixGetTriangleBarycentrics();
    result.barycentrics[0] = barycentrics.x;
    result.barycentrics[1] = barycentrics.y;
    result.primitive = optixGetPrimitiveIndex();
    result.instanceId = optixGetInstanceId();
    result.instanceIndex = optixGetInstanceIndex();
    result.hitKind = optixGetHitKind();
    result.front = optixIsFrontFaceHit() && optixIsTriangleHit() && !optixIsTriangleBackFaceHit() &&
                   optixGetPrimitiveType() == OPTIX_PRIMITIVE_TYPE_TRIANGLE;
    result.listSize = optixGetTransformListSize();
    for (unsigned int i = 0; i < result.listSize && i < 8; ++i)
        result.listTypes[i] =
            (unsigned int)optixGetTransformTypeFromHandle(optixGetTransformListHandle(i));
    optixGetObjectToWorldTransformMatrix(result.objectToWorld);
    optixGetWorldToObjectTransformMatrix(result.worldToObject);
    store(result.normalWorld,
          optixTransformNormalFromObjectToWorldSpace(make_float3(0.0f, 0.0f, 1.0f)));
    store(result.pointBack, optixTransformPointFromObjectToWorldSpace(
                                optixTransformPointFromWorldToObjectSpace(load(params.origin))));
    float3 vertices[3];
    optixGetTriangleVertexData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                               optixGetSbtGASIndex(), optixGetRayTime(), vertices);
    for (int i = 0; i < 3; ++i)
        store(result.vertices + 3 * i, vertices[i]);
    optixSetPayload_0(optixGetPayload_0() + 1);
    optixSetPayload_7(optixGetPayload_7() + 7);
    optixSetPayload_31(optixGetPayload_31() * 2);
}

extern "C" __global__ void __intersection__interop() {
    optixReportIntersection(2.0f, 5u); // the nearer report below replaces it
    optixReportIntersection(1.5f, 9u, 1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u);
}

extern "C" __global__ void __closesthit__custom() {
    Result& result = *params.result;
    result.hits += 1;
    result.t = optixGetRayTmax();
    result.hitKind = optixGetHitKind();
    result.attributes = optixGetAttribute_0() + 10 * optixGetAttribute_1() +
                        100 * optixGetAttribute_2() + 1000 * optixGetAttribute_3() +
                        10000 * optixGetAttribute_4() + 100000 * optixGetAttribute_5() +
                        1000000 * optixGetAttribute_6() + 10000000 * optixGetAttribute_7();
}

extern "C" __global__ void __exception__interop() {
    Result& result = *params.result;
    result.exceptionCode = optixGetExceptionCode();
    result.exceptionDetails[0] = optixGetExceptionDetail_0();
    result.exceptionDetails[1] = optixGetExceptionDetail_1();
}
