// SPDX-License-Identifier: Apache-2.0
// Baking: a launch index per texel, whose position and normal are in buffers, and rays over its
// hemisphere. Payload: the light that the ray finds.
#include "lightmap.h"
#include "tools.h"

extern "C" {
__constant__ LightmapParams bake;
}

extern "C" __global__ void __closesthit__light() {
    const float4 light = __ldg(&bake.leaving[optixGetPrimitiveIndex()]);
    // Triangles shine on their upper side only.
    const float side = optixIsTriangleFrontFaceHit() ? 1.0f : 0.85f;
    optixSetPayload_0(__float_as_uint(light.x * side));
    optixSetPayload_1(__float_as_uint(light.y * side));
    optixSetPayload_2(__float_as_uint(light.z * side));
}
extern "C" __global__ void __miss__sky() {
    const float3 c = blueSky(optixGetWorldRayDirection());
    optixSetPayload_0(__float_as_uint(c.x));
    optixSetPayload_1(__float_as_uint(c.y));
    optixSetPayload_2(__float_as_uint(c.z));
}

extern "C" __global__ void __raygen__bake() {
    const unsigned texel = bake.firstTexel + optixGetLaunchIndex().x;
    const float4 p = bake.positions[texel], n = bake.normals[texel];
    if (p.w <= 0.0f) { // outside of all charts
        bake.texels[texel] = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
        return;
    }
    const float3 normal = vec(n.x, n.y, n.z);
    const float3 origin = vec(p.x, p.y, p.z) + normal * bake.bias;
    unsigned random = hashPcg(texel ^ bake.seed);
    const float shiftU = nextFloat(random), shiftV = nextFloat(random);
    float3 sum = vec(0.0f);
    for (int i = 0; i < bake.raysPerTexel; ++i) {
        // A lattice, shifted for each texel.
        float u = (i + 0.5f) / bake.raysPerTexel + shiftU, v = i * 0.618034f + shiftV;
        u -= floorf(u);
        v -= floorf(v);
        unsigned r = 0, g = 0, b = 0;
        optixTrace(bake.handle, origin, cosineDirection(normal, u, v), 0.0f, 1e16f, 0.0f,
                   OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, r, g, b);
        sum += vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
    }
    bake.texels[texel] = withWeight(sum / float(bake.raysPerTexel), 1.0f);
}
