// SPDX-License-Identifier: Apache-2.0
// A database index: each key is a small triangle at a place of a grid. A query is one ray along
// each line of keys in its range; the any-hit program counts. Payload: the count, the sum of the
// rows, the largest row, and the smallest.
#include "key_queries.h"
#include "tools.h"

extern "C" {
__constant__ KeyParams params;
}

extern "C" __global__ void __anyhit__match() {
    const unsigned row = params.rows[optixGetPrimitiveIndex()];
    optixSetPayload_0(optixGetPayload_0() + 1);
    optixSetPayload_1(optixGetPayload_1() + (row & 1023u));
    optixSetPayload_2(max(optixGetPayload_2(), row));
    optixSetPayload_3(min(optixGetPayload_3(), row));
    optixIgnoreIntersection();
}

extern "C" __global__ void __miss__nothing() {}

extern "C" __global__ void __raygen__lookup() {
    const unsigned query = optixGetLaunchIndex().x;
    const KeyRange range = params.queries[query];
    constexpr unsigned kColumns = 1u << kColumnBits;
    unsigned count = 0, sum = 0, largest = 0, smallest = 0xffffffffu;
    for (unsigned line = range.first / kColumns; line <= range.last / kColumns; ++line) {
        const unsigned first = max(range.first, line * kColumns);
        const unsigned last = min(range.last, line * kColumns + kColumns - 1);
        float3 origin = placeOfKey(first);
        origin.x -= 0.5f;
        optixTrace(params.index, origin, make_float3(1.0f, 0.0f, 0.0f), 0.0f,
                   float(last - first) + 1.0f, 0.0f, OptixVisibilityMask(1),
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT | OPTIX_RAY_FLAG_ENFORCE_ANYHIT, 0, 0, 0,
                   count, sum, largest, smallest);
    }
    params.answers[query] = make_float4(float(count), float(sum & 0xfffffu),
                                        float((largest ^ smallest) & 0xfffffu), float(query));
}

// A key alone: a ray across the lines, which ends at the first triangle.
extern "C" __global__ void __raygen__exists() {
    const unsigned query = optixGetLaunchIndex().x;
    float3 origin = placeOfKey(params.queries[query].first);
    origin.z -= 0.5f;
    unsigned count = 0, sum = 0, largest = 0, smallest = 0xffffffffu;
    optixTrace(params.index, origin, make_float3(0.0f, 0.0f, 1.0f), 0.0f, 1.0f, 0.0f,
               OptixVisibilityMask(1), OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 0, 0, 0, count, sum,
               largest, smallest);
    params.answers[query] = make_float4(float(count), float(sum), 0.0f, float(query));
}
