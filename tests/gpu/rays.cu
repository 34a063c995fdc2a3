// SPDX-License-Identifier: Apache-2.0
// Device programs of run_test.cpp: one ray for each launch index. The any-hit program ignores
// triangles of odd number.
#include "rays.h"

#include <optix.h>

extern "C" {
__constant__ TestParams params;
}

extern "C" __global__ void __raygen__rays() {
    const unsigned int i = optixGetLaunchIndex().x;
    const TestRay r = params.rays[i];
    unsigned int t = 0, u = 0, v = 0, primitive = ~0u, asked = 0;
    optixTrace(params.handle, make_float3(r.origin[0], r.origin[1], r.origin[2]),
               make_float3(r.direction[0], r.direction[1], r.direction[2]), r.tmin, r.tmax, 0.0f, 255,
               params.flags, 0, 1, 0, t, u, v, primitive, asked);
    TestHit hit;
    hit.t = __uint_as_float(t);
    hit.u = __uint_as_float(u);
    hit.v = __uint_as_float(v);
    hit.primitive = primitive;
    hit.asked = asked;
    params.hits[i] = hit;
}

extern "C" __global__ void __miss__none() {
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
}

extern "C" __global__ void __closesthit__store() {
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    // Of curves, u alone; spheres have none.
    const bool curve = optixGetPrimitiveType() != OPTIX_PRIMITIVE_TYPE_TRIANGLE &&
                       optixGetPrimitiveType() != OPTIX_PRIMITIVE_TYPE_CUSTOM;
    const float2 weights =
        curve ? make_float2(optixGetCurveParameter(), 0) : optixGetTriangleBarycentrics();
    optixSetPayload_1(__float_as_uint(weights.x));
    optixSetPayload_2(__float_as_uint(weights.y));
    optixSetPayload_3(optixGetPrimitiveIndex());
}

extern "C" __global__ void __anyhit__even() {
    optixSetPayload_4(optixGetPayload_4() + 1);
    if (optixGetPrimitiveIndex() & 1)
        optixIgnoreIntersection();
}
