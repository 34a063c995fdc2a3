// SPDX-License-Identifier: Apache-2.0
// Device programs of loop_test.cpp. With ONE_PLACE, ray generation traces at one place in a loop,
// so that the compiler cuts the program there; else at two. With IN_CALLABLES, its rays and those of
// the closest-hit program are traced by two continuation callables.
#include "loop.h"

#include <optix.h>

extern "C" {
__constant__ LoopParams params;
}

static __forceinline__ __device__ unsigned int place() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    return (index.z * size.y + index.y) * size.x + index.x;
}

static __forceinline__ __device__ void trace(const TestRay& r, unsigned int& hit,
                                             unsigned int& primitive, unsigned int& levels) {
    optixTrace(params.handle, make_float3(r.origin[0], r.origin[1], r.origin[2]),
               make_float3(r.direction[0], r.direction[1], r.direction[2]), r.tmin, r.tmax, 0.0f, 255,
               params.flags, 0, 1, 0, hit, primitive, levels);
}

#ifdef IN_CALLABLES
static __forceinline__ __device__ void traceBy(unsigned int callable, const TestRay& ray,
                                               unsigned int& hit, unsigned int& primitive,
                                               unsigned int& levels) {
    optixContinuationCall<void, const TestRay&, unsigned int&, unsigned int&, unsigned int&>(
        callable, ray, hit, primitive, levels);
}
#endif

// Every ray may be the last, and every third trace is one of two.
extern "C" __global__ void __raygen__loop() {
    const unsigned int number = place(), count = number % params.most;
    unsigned int recent[4] = {1, 2, 3, 4}; // lives across traces, in memory
    LoopResult result = {};
    for (unsigned int k = 0; k < count; ++k) {
        if (k % 3 == 2 && result.hits == 0)
            continue;
        const TestRay& ray = params.rays[(number * 7 + k * 13) % params.rayCount];
        unsigned int hit = 0, primitive = number, levels = 2;
#ifdef IN_CALLABLES
        traceBy(k & 1, ray, hit, primitive, levels);
#elif defined(ONE_PLACE)
        trace(ray, hit, primitive, levels);
#else
        if (k & 1)
            trace(ray, hit, primitive, levels);
        else
            trace(ray, hit, primitive, levels);
#endif
        ++result.traces;
        result.hits += hit;
        recent[(primitive + k) & 3] = primitive + levels;
        result.checksum = result.checksum * 31 + recent[k & 3];
        if (number % 5 == params.throwAt)
            optixThrowException(int(number));
        if (result.hits == 4)
            break;
    }
    params.results[number] = result;
}

extern "C" __global__ void __miss__none() {
    optixSetPayload_1(77);
}

// A ray from the hit continues through the surface, once.
extern "C" __global__ void __closesthit__again() {
    const unsigned int levels = optixGetPayload_2();
    unsigned int hit = 0, primitive = optixGetPrimitiveIndex(), rest = levels - 1;
    if (levels == 1 && place() % 5 == params.throwBelow)
        optixThrowException(1000);
    if (levels > 1) {
        const float3 o = optixGetWorldRayOrigin(), d = optixGetWorldRayDirection();
        const float t = optixGetRayTmax() * 1.001f;
        unsigned int next = 0;
        const TestRay ray = {
            {o.x + t * d.x, o.y + t * d.y, o.z + t * d.z}, 0.0f, {d.x, d.y, d.z}, 1e16f};
#ifdef IN_CALLABLES
        traceBy(primitive & 1, ray, hit, next, rest);
#else
        trace(ray, hit, next, rest);
#endif
        primitive += next * 3;
    }
    optixSetPayload_0(1);
    optixSetPayload_1(primitive);
    optixSetPayload_2(rest + optixGetLaunchIndex().x % 2);
}

extern "C" __global__ void __anyhit__odd() {
    if (optixGetPrimitiveIndex() % 3 == 1)
        optixTerminateRay();
    if (optixGetPrimitiveIndex() & 1)
        optixIgnoreIntersection();
}

extern "C" __global__ void __exception__note() {
    params.results[place()].thrown = 1 + unsigned(optixGetExceptionCode());
}

#ifdef IN_CALLABLES
// Their records' data are 1000 and 2000.
static __forceinline__ __device__ bool hasData(unsigned int value) {
    return *reinterpret_cast<const unsigned int*>(optixGetSbtDataPointer()) == value;
}
extern "C" __device__ void __continuation_callable__once(const TestRay& ray, unsigned int& hit,
                                                         unsigned int& primitive,
                                                         unsigned int& levels) {
    trace(ray, hit, primitive, levels);
    if (!hasData(1000))
        hit += 100;
}
// Traces another ray first, and has a value that lives across both traces.
extern "C" __device__ void __continuation_callable__twice(const TestRay& ray, unsigned int& hit,
                                                          unsigned int& primitive,
                                                          unsigned int& levels) {
    const bool known = hasData(2000);
    unsigned int first = 0, other = 0, one = 1;
    if (levels == 2)
        optixTrace(params.handle, make_float3(ray.origin[0], ray.origin[1], ray.origin[2]),
                   make_float3(-ray.direction[0], -ray.direction[1], -ray.direction[2]), 0.0f, 1.0f,
                   0.0f, 255, params.flags | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 0, 1, 0, first,
                   other, one);
    trace(ray, hit, primitive, levels);
    if (!known || first != 0)
        hit += 100;
}
#endif
