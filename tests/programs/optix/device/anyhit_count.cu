// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "anyhit_count.h"

extern "C" __constant__ Params params;

static __forceinline__ __device__ float dot(float3 a, float3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

extern "C" __global__ void __raygen__count() {
    const unsigned i = optixGetLaunchIndex().x, n = optixGetLaunchDimensions().x;
    const float y = (i / 32 + 0.5f) / (n / 32) * 8.0f, z = (i % 32 + 0.5f) / 4.0f;
    unsigned count = 0, sum = 0, seen[2] = {0, 0};
    optixTrace(params.spheres, make_float3(-1.0f, y, z), make_float3(1, 0, 0), 0.0f, 100.0f, 0.0f,
               255, OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 0, 0, 0, count, sum, seen[0], seen[1]);
    params.result[i] = make_uint2(count, sum);
    if (seen[0] + seen[1])
        atomicAdd(params.reports, (unsigned long long)(seen[0] + seen[1]));
}

extern "C" __global__ void __intersection__ball() {
    const unsigned i = optixGetPrimitiveIndex();
    const float4 ball = params.balls[i];
    const float3 from = optixGetObjectRayOrigin(), way = optixGetObjectRayDirection();
    const float3 to = make_float3(ball.x - from.x, ball.y - from.y, ball.z - from.z);
    const float middle = dot(to, way), rest = ball.w * ball.w - (dot(to, to) - middle * middle);
    if (rest <= 0.0f)
        return;
    const float half = sqrtf(rest);
    // Both surfaces are reported; the any-hit program tells them apart by the kind.
    if (!optixReportIntersection(middle - half, 1, __float_as_uint(middle)))
        optixReportIntersection(middle + half, 2, __float_as_uint(middle));
}

extern "C" __global__ void __anyhit__count() {
    if (optixGetHitKind() == 1) {
        optixSetPayload_0(optixGetPayload_0() + 1);
        const float sum = __uint_as_float(optixGetPayload_1()) + optixGetRayTmax();
        optixSetPayload_1(__float_as_uint(sum));
        optixSetPayload_2(optixGetPayload_2() + 1);
        if (optixGetPayload_0() >= params.limit)
            optixTerminateRay();
    } else {
        optixSetPayload_3(optixGetPayload_3() + 1);
    }
    optixIgnoreIntersection();
}
extern "C" __global__ void __closesthit__never() {
    optixSetPayload_0(12345);
}
