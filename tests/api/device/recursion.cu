// SPDX-License-Identifier: Apache-2.0
// Traces within closest-hit and miss programs: a ray bounces between the planes z = 0 and z = 1,
// each hit traces back, to a given depth. Powers separate the contributions of the levels.
#include <optix.h>

struct RecursionParams {
    unsigned long long handle;
    unsigned long long* results; // value and count, for each launch index
    unsigned depth;              // levels wanted
    unsigned missTraces;         // the miss program traces on, towards the planes
    const unsigned* table;       // of the program that keeps much
};

extern "C" {
__constant__ RecursionParams params;
}

static __forceinline__ __device__ unsigned long long join(unsigned high, unsigned low) {
    return (static_cast<unsigned long long>(high) << 32) | low;
}

// Traces one level deeper and folds the result: value * 3 + level.
static __forceinline__ __device__ void descend(float z, float direction, unsigned level) {
    unsigned low = level, high = 0, count = 0;
    optixTrace(params.handle, make_float3(0.25f, 0.25f, z), make_float3(0.0f, 0.0f, direction),
               1e-3f, 10.0f, 0.0f, 255, 0, 0, 0, 0, low, high, count);
    const unsigned long long value = join(high, low) * 3 + level;
    optixSetPayload_0(static_cast<unsigned>(value));
    optixSetPayload_1(static_cast<unsigned>(value >> 32));
    optixSetPayload_2(count + 1);
}

extern "C" __global__ void __raygen__recursion() {
    const unsigned i = optixGetLaunchIndex().x;
    // Even indices start towards the planes, odd ones away from them.
    unsigned low = 0, high = 0, count = 0;
    optixTrace(params.handle, make_float3(0.25f, 0.25f, 0.5f),
               (i & 1) ? make_float3(1.0f, 0.0f, 0.0f) : make_float3(0.0f, 0.0f, 1.0f), 1e-3f,
               10.0f, 0.0f, 255, 0, 0, 0, 0, low, high, count);
    params.results[2 * i] = join(high, low);
    params.results[2 * i + 1] = count;
}

static __forceinline__ __device__ void descendToTheEnd(unsigned level) {
    if (level < params.depth) {
        const float direction = optixGetWorldRayDirection().z;
        const float z = optixGetWorldRayOrigin().z + direction * optixGetRayTmax();
        descend(z, -direction, level);
        return;
    }
    optixSetPayload_0(level);
    optixSetPayload_1(0);
    optixSetPayload_2(1);
}

extern "C" __global__ void __closesthit__recursion() {
    descendToTheEnd(optixGetPayload_0() + 1);
}

// The same; an exception ends every eighth launch index at its deepest ray, but for every 512th.
extern "C" __global__ void __closesthit__thrower() {
    const unsigned level = optixGetPayload_0() + 1, index = optixGetLaunchIndex().x;
    if (level >= params.depth && index % 8 == 0 && index % 512 != 0)
        optixThrowException(7);
    descendToTheEnd(level);
}

// The same, with far more values across the trace than there are registers.
extern "C" __global__ void __closesthit__keeper() {
    constexpr unsigned kKept = 96; // see the test RecursionKeepsMuch
    const unsigned level = optixGetPayload_0() + 1;
    if (level >= params.depth) {
        optixSetPayload_0(level);
        optixSetPayload_1(0);
        optixSetPayload_2(1);
        return;
    }
    unsigned kept[kKept];
#pragma unroll
    for (unsigned i = 0; i < kKept; ++i)
        kept[i] = params.table[(i * 37 + level * 5 + optixGetLaunchIndex().x) & 1023];
    const float direction = optixGetWorldRayDirection().z;
    descend(optixGetWorldRayOrigin().z + direction * optixGetRayTmax(), -direction, level);
    unsigned sum = 0;
#pragma unroll
    for (unsigned i = 0; i < kKept; ++i)
        sum = sum * 3 + kept[i];
    optixSetPayload_2(optixGetPayload_2() * 7 + sum);
}

extern "C" __global__ void __miss__recursion() {
    const unsigned level = optixGetPayload_0() + 1;
    if (params.missTraces && level < params.depth) {
        descend(0.5f, 1.0f, level);
        return;
    }
    optixSetPayload_0(7);
    optixSetPayload_1(0);
    optixSetPayload_2(1);
}
