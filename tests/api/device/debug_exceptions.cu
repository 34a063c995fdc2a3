// SPDX-License-Identifier: Apache-2.0
// Makes the mistakes of debug_exceptions.h and stores the details that the exception program gets.
#include <optix.h>

#include "debug_exceptions.h"

extern "C" {
__constant__ DebugParams params;
}

static __forceinline__ __device__ unsigned mistakeOf() {
    return params.mistake == kMistakes ? optixGetLaunchIndex().x % kMistakes : params.mistake;
}

static __forceinline__ __device__ void trace(OptixTraversableHandle handle, float tmax,
                                             unsigned sbtOffset, unsigned miss, float z,
                                             unsigned& payload,
                                             unsigned flags = OPTIX_RAY_FLAG_NONE) {
    optixTrace(handle, make_float3(0, 0, -1), make_float3(0, 0, z), 0.0f, tmax, 0.5f, 255, flags,
               sbtOffset, 1, miss, payload);
}

extern "C" __device__ unsigned __direct_callable__two(unsigned a, unsigned b) {
    return a + b;
}

extern "C" __device__ unsigned __direct_callable__again(unsigned depth) {
    volatile unsigned frame[256];
    frame[depth & 255] = depth;
    return optixDirectCall<unsigned, unsigned>(1, depth + 1) + frame[depth & 255];
}

extern "C" __device__ unsigned __continuation_callable__sum(unsigned a, unsigned b) {
    return a + b;
}

static __noinline__ __device__ unsigned recurse(volatile unsigned* seen, unsigned depth) {
    volatile unsigned frame[64];
    frame[depth & 63] = depth;
    if (seen[0] == 12345u)
        return depth;
    return recurse(seen, depth + 1) + frame[depth & 63];
}

// Two megabytes for each call.
static __noinline__ __device__ unsigned large(volatile unsigned* seen, unsigned depth) {
    volatile unsigned frame[1 << 19];
    for (unsigned i = 0; i < 1 << 19; i += 512)
        frame[i] = depth;
    if (depth == 64)
        return seen[0];
    return large(seen, depth + 1) + frame[depth * 512];
}

static __forceinline__ __device__ void makeMistake(DebugResult& result) {
    unsigned payload = mistakeOf();
    float3 vertices[3];
    switch (mistakeOf()) {
    case kBadTraversable:
        trace(params.gas + 48, 10.0f, 0, 0, 1.0f, payload);
        break;
    case kBadMiss:
        trace(params.ias, 10.0f, 0, 7, -1.0f, payload);
        break;
    case kBadHit:
        trace(params.ias, 10.0f, 200, 0, 1.0f, payload);
        break;
    case kBadRay:
        trace(params.ias, 10.0f, 0, 0, __int_as_float(0x7f800000), payload);
        break;
    case kWrongParameters:
        payload = optixDirectCall<unsigned, unsigned, unsigned, double>(0, 1u, 2u, 3.0);
        break;
    case kCallableOutOfRange:
        payload = optixDirectCall<unsigned, unsigned>(77, 1u);
        break;
    case kNoDirect:
        payload = optixDirectCall<unsigned, unsigned, unsigned>(2, 1u, 2u);
        break;
    case kNoContinuation:
        payload = optixContinuationCall<unsigned, unsigned, unsigned>(0, 1u, 2u);
        break;
    case kBadGasForVertices:
        optixGetTriangleVertexData(params.ias, 0, 0, 0.0f, vertices);
        payload = __float_as_uint(vertices[1].y);
        break;
    case kBadPrimitive:
        optixGetTriangleVertexData(params.gas, 9, 0, 0.0f, vertices);
        payload = __float_as_uint(vertices[1].y);
        break;
    case kBadSbtGasIndex:
        optixGetTriangleVertexData(params.gas, 0, 3, 0.0f, vertices);
        payload = __float_as_uint(vertices[1].y);
        break;
    case kNoVertexAccess:
        optixGetTriangleVertexData(params.plainGas, 0, 0, 0.0f, vertices);
        payload = __float_as_uint(vertices[1].y);
        break;
    case kNoInstanceAccess:
        payload = unsigned(optixGetInstanceTraversableFromIAS(params.plainIas, 0));
        break;
    case kBadInstance:
        payload = unsigned(optixGetInstanceTraversableFromIAS(params.ias, 5));
        break;
    case kDeepCallables:
        payload = optixDirectCall<unsigned, unsigned>(1, 0u);
        break;
    case kDeepRecursion:
        payload = recurse(&result.detail, 0);
        break;
    case kReportKind:
        trace(params.customs, 10.0f, 1, 0, 1.0f, payload);
        break;
    case kAnyHitFlags: // any two of four
        trace(params.ias, 10.0f, 0, 0, 1.0f, payload,
              optixGetLaunchIndex().x & 32
                  ? OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_CULL_ENFORCED_ANYHIT
                  : OPTIX_RAY_FLAG_ENFORCE_ANYHIT | OPTIX_RAY_FLAG_CULL_DISABLED_ANYHIT);
        break;
    case kThrowCode:
        optixThrowException(-int(payload));
        break;
    case kFaceFlags:
        trace(params.ias, 10.0f, 0, 0, 1.0f, payload,
              OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES |
                  OPTIX_RAY_FLAG_CULL_FRONT_FACING_TRIANGLES);
        break;
    default:
        trace(params.ias, 10.0f, 0, 0, 1.0f, payload);
    }
    result.detail = payload;
}

extern "C" __global__ void __raygen__mistakes() {
    DebugResult& result = params.results[optixGetLaunchIndex().x];
    result.reached = 0;
    result.code = 1000;
    makeMistake(result);
    result.reached = 1;
}

extern "C" __global__ void __raygen__large() {
    DebugResult& result = params.results[optixGetLaunchIndex().x];
    result.reached = 0;
    result.code = 1000;
    result.detail = large(&result.detail, 0);
    result.reached = 1;
}

extern "C" __global__ void __closesthit__mistakes() {
    unsigned payload = optixGetPayload_0();
    if (payload == kDeepTrace)
        trace(params.ias, 10.0f, 0, 0, 1.0f, payload);
    if (payload == kListIndex)
        payload = unsigned(optixGetTransformListHandle(optixGetTransformListSize()));
    optixSetPayload_0(payload + 100);
}

extern "C" __global__ void __intersection__mistakes() {
    optixReportIntersection(1.0f, 200);
}

extern "C" __global__ void __miss__mistakes() {
    optixSetPayload_0(500);
}

static __forceinline__ __device__ void copyText(char* to, unsigned size, const char* from) {
    unsigned i = 0;
    for (; from && from[i] && i + 1 < size; ++i)
        to[i] = from[i];
    to[i] = 0;
}

extern "C" __global__ void __exception__mistakes() {
    DebugResult& result = params.results[optixGetLaunchIndex().x];
    result.code = optixGetExceptionCode();
    result.listSize = optixGetTransformListSize();
    result.listType =
        result.listSize ? optixGetTransformTypeFromHandle(optixGetTransformListHandle(0)) : 77;
    result.sbtGasIndex = optixGetSbtGASIndex();
    result.traversable = optixGetExceptionInvalidTraversable();
    result.sbtOffset = optixGetExceptionInvalidSbtOffset();
    const OptixInvalidRayExceptionDetails ray = optixGetExceptionInvalidRay();
    const float values[9] = {ray.origin.x, ray.origin.y,   ray.origin.z,
                             ray.direction.x, ray.direction.y, ray.direction.z,
                             ray.tmin, ray.tmax, ray.time};
    for (int i = 0; i < 9; ++i)
        result.ray[i] = values[i];
    const OptixParameterMismatchExceptionDetails call = optixGetExceptionParameterMismatch();
    result.expected = call.expectedParameterCount;
    result.passed = call.passedArgumentCount;
    result.callableIndex = call.sbtIndex;
    copyText(result.name, sizeof(result.name), call.callableName);
    copyText(result.line, sizeof(result.line), optixGetExceptionLineInfo());
    result.detail = optixGetExceptionDetail_0();
}
