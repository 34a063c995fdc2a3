// SPDX-License-Identifier: Apache-2.0
// User exceptions thrown from several program kinds, and a continuation callable that traces.
#include <optix.h>

#include "exceptions.h"

extern "C" {
__constant__ ExceptionParams params;
}

struct RecordData {
    unsigned value;
};

static __forceinline__ __device__ unsigned index() { return optixGetLaunchIndex().x; }

static __forceinline__ __device__ void trace(unsigned kind, unsigned& seen) {
    optixTrace(params.handle, make_float3(0, 0, -1), make_float3(0, 0, kind == kFromMiss ? -1 : 1), 0.0f,
               1e16f, 0.0f, 255, OPTIX_RAY_FLAG_NONE, 0, 1, 0, kind, seen);
}

extern "C" __device__ unsigned __continuation_callable__trace(unsigned kind, unsigned add) {
    unsigned seen = 0;
    trace(kind, seen);
    return seen + add;
}

extern "C" __global__ void __raygen__exceptions() {
    const unsigned i = index();
    ExceptionResult& result = params.results[i];
    result.reached = 1;
    switch (i % kKinds) {
    case kFromRaygen:
        optixThrowException(100, i, 2u, 3u, 4u, 5u, 6u, 7u, 8u);
        break;
    case kFromCallable:
        result.value = optixContinuationCall<unsigned, unsigned, unsigned>(0, kFromHit, 1u);
        break;
    case kNone:
        result.value = optixContinuationCall<unsigned, unsigned, unsigned>(0, kNone, 1000u);
        break;
    default:
        trace(i % kKinds, result.value);
    }
    result.reached = 2;
}

extern "C" __global__ void __closesthit__exceptions() {
    if (optixGetPayload_0() == kFromHit)
        optixThrowException(200, index());
    optixSetPayload_1(77);
}

extern "C" __global__ void __anyhit__exceptions() {
    if (optixGetPayload_0() == kFromAnyHit)
        optixThrowException(0);
}

extern "C" __global__ void __miss__exceptions() {
    optixThrowException((1 << 30) - 1, index(), 9u);
}

extern "C" __global__ void __exception__store() {
    ExceptionResult& result = params.results[index()];
    result.code = optixGetExceptionCode();
    result.details[0] = optixGetExceptionDetail_0();
    result.details[1] = optixGetExceptionDetail_1();
    result.details[2] = optixGetExceptionDetail_7();
    result.value = optixGetExceptionDetail_2() + 10 * optixGetExceptionDetail_3() +
                   100 * optixGetExceptionDetail_4() + 1000 * optixGetExceptionDetail_5() +
                   10000 * optixGetExceptionDetail_6();
    if (index() == 1)
        optix_impl::optixDumpExceptionDetails();
    result.record = reinterpret_cast<const RecordData*>(optixGetSbtDataPointer())->value;
}
