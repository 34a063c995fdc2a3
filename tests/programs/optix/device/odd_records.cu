// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "odd_records.h"

extern "C" __constant__ Params params;

extern "C" __global__ void __raygen__grid() {
    const RaygenData& data = *reinterpret_cast<const RaygenData*>(optixGetSbtDataPointer());
    const uint3 at = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned type = at.z;
    unsigned a = data.tag, b = 0;
    optixTrace(params.scene, make_float3(at.x + 0.3f, at.y + 0.3f, data.height),
               make_float3(0, 0, -1), 0.0f, 100.0f, 0.0f, 255, OPTIX_RAY_FLAG_NONE, type,
               data.rayTypes, type, a, b);
    const unsigned to = 2 * ((at.z * size.y + at.y) * size.x + at.x);
    params.seen[to] = a;
    params.seen[to + 1] = b;
}
extern "C" __global__ void __closesthit__record() {
    const HitData& data = *reinterpret_cast<const HitData*>(optixGetSbtDataPointer());
    optixSetPayload_0(data.id + 1000u * data.type + 100000u * (unsigned char)(data.name[20]));
    optixSetPayload_1(data.colour ? data.colour->words[optixGetPrimitiveIndex() % 3] : 7u);
}
extern "C" __global__ void __miss__record() {
    const MissData& data = *reinterpret_cast<const MissData*>(optixGetSbtDataPointer());
    optixSetPayload_0((unsigned)data.code + optixGetPayload_0());
    optixSetPayload_1((unsigned)(data.code >> 32));
}
