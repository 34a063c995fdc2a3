// SPDX-License-Identifier: Apache-2.0
// Any-hit programs read leaves from textures: camera rays cut at an opacity, shadow rays multiply
// what passes. Payload: normal, colour; for shadow rays the light that is left and its presence.
#include "forest.h"
#include "tools.h"

extern "C" {
__constant__ ForestParams params;
}

DEVICE const ForestRecord& record() {
    return *reinterpret_cast<const ForestRecord*>(optixGetSbtDataPointer());
}
// A leaf is a pair of triangles, (0, 0) (1, 0) (1, 1) and (0, 0) (1, 1) (0, 1).
DEVICE float4 leafColor(cudaTextureObject_t texture) {
    const float2 b = optixGetTriangleBarycentrics();
    const bool isSecond = optixGetPrimitiveIndex() % 2 != 0;
    return isSecond ? tex2D<float4>(texture, b.x, b.x + b.y)
                    : tex2D<float4>(texture, b.x + b.y, b.y);
}

extern "C" __global__ void __anyhit__leaf() {
    const ForestRecord& r = record();
    if (leafColor(r.texture).w < r.cutoff)
        optixIgnoreIntersection();
}
extern "C" __global__ void __anyhit__dapple() {
    const float opacity = leafColor(record().texture).w;
    const float left = __uint_as_float(optixGetPayload_0()) * (1.0f - 0.8f * opacity);
    optixSetPayload_0(__float_as_uint(left));
    if (left < 0.02f)
        optixTerminateRay();
    else
        optixIgnoreIntersection();
}

extern "C" __global__ void __closesthit__shade() {
    const ForestRecord& r = record();
    const float3 local = r.mesh.normal(optixGetPrimitiveIndex());
    const float3 normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    float3 color = r.color;
    if (r.texture) {
        const float4 texel = leafColor(r.texture);
        color = color * vec(texel.x, texel.y, texel.z);
    }
    const float3 point = rayPoint() + normal * 2e-3f;
    const float cosine = dot(normal, params.sun);
    const float through = r.texture ? 0.5f * fabsf(cosine) : 0.0f; // leaves let light pass
    const float share = fmaxf(cosine, through);
    unsigned left = __float_as_uint(1.0f), lit = 0, unused = 0;
    if (share > 0.0f)
        optixTrace(params.world, point, params.sun, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 1, 2,
                   1, left, lit, unused, unused, unused, unused);
    float3 light = blueSky(normal) * 0.3f;
    if (lit)
        light += vec(1.6f, 1.45f, 1.15f) * (share * __uint_as_float(left));
    color = color * light;
    optixSetPayload_0(__float_as_uint(normal.x));
    optixSetPayload_1(__float_as_uint(normal.y));
    optixSetPayload_2(__float_as_uint(normal.z));
    optixSetPayload_3(__float_as_uint(color.x));
    optixSetPayload_4(__float_as_uint(color.y));
    optixSetPayload_5(__float_as_uint(color.z));
}
extern "C" __global__ void __miss__sky() {
    const float3 color = blueSky(optixGetWorldRayDirection());
    optixSetPayload_3(__float_as_uint(color.x));
    optixSetPayload_4(__float_as_uint(color.y));
    optixSetPayload_5(__float_as_uint(color.z));
}
extern "C" __global__ void __miss__lit() {
    optixSetPayload_1(1);
}

extern "C" __global__ void __raygen__forest() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        unsigned p[6] = {};
        optixTrace(params.world, params.camera.eye, cameraDirection(params.camera, x, y), 0.0f,
                   1e16f, 0.0f, OptixVisibilityMask(255), OPTIX_RAY_FLAG_NONE, 0, 2, 0, p[0], p[1],
                   p[2], p[3], p[4], p[5]);
        sum += vec(__uint_as_float(p[3]), __uint_as_float(p[4]), __uint_as_float(p[5]));
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
