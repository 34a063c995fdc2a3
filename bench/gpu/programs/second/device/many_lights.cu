// SPDX-License-Identifier: Apache-2.0
// 32 lights, and a shadow ray to each from the closest-hit program. Leaves have an any-hit program
// that reads an alpha texture, the ground has none. Payload: the colour; of shadow rays one word.
#include "many_lights.h"
#include "tools.h"

extern "C" {
__constant__ LanternParams params;
}

DEVICE void answer(float3 p) {
    optixSetPayload_0(__float_as_uint(p.x));
    optixSetPayload_1(__float_as_uint(p.y));
    optixSetPayload_2(__float_as_uint(p.z));
}

// Leaves are pairs of triangles, (0, 0) (1, 0) (1, 1) and (0, 0) (1, 1) (0, 1).
DEVICE float4 leafTexel(cudaTextureObject_t mask) {
    const float2 b = optixGetTriangleBarycentrics();
    const float2 uv = optixGetPrimitiveIndex() % 2 == 0 ? make_float2(b.x + b.y, b.y)
                                                        : make_float2(b.x, b.x + b.y);
    return tex2D<float4>(mask, uv.x, uv.y);
}

extern "C" __global__ void __anyhit__cutout() {
    const LanternRecord* record = reinterpret_cast<LanternRecord*>(optixGetSbtDataPointer());
    if (leafTexel(record->mask).w < 0.5f)
        optixIgnoreIntersection();
}

DEVICE bool isOccluded(float3 from, float3 direction, float length) {
    unsigned occluded = 1u, p1 = 0u, p2 = 0u;
    optixTrace(params.handle, from, direction, 1e-3f, length - 1e-3f, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 1, 2, 1,
               occluded, p1, p2);
    return occluded != 0u;
}

extern "C" __global__ void __closesthit__radiance() {
    const LanternRecord* record = reinterpret_cast<LanternRecord*>(optixGetSbtDataPointer());
    const uint3 corners = record->indices[optixGetPrimitiveIndex()];
    const float3 v0 = record->vertices[corners.x];
    const float3 normal = towardsRay(
        normalize(cross(record->vertices[corners.y] - v0, record->vertices[corners.z] - v0)));
    const float3 point = rayPoint() + normal * 1e-3f;
    float3 diffuse = record->diffuse;
    if (record->mask != 0) {
        const float4 texel = leafTexel(record->mask);
        diffuse = diffuse * vec(texel.x, texel.y, texel.z);
    }
    float3 result = params.ambient * diffuse;
    for (int i = 0; i < kLanterns; ++i) {
        const Lantern light = params.lanterns[i];
        const float distance = length(light.position - point);
        const float3 direction = normalize(light.position - point);
        const float cosine = dot(normal, direction);
        if (cosine > 0.0f && !isOccluded(point, direction, distance))
            result += diffuse * light.power * (cosine / (distance * distance + 1.0f));
    }
    answer(result);
}

extern "C" __global__ void __miss__background() {
    answer(blueSky(optixGetWorldRayDirection()) * 0.05f);
}
extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(0u);
}

extern "C" __global__ void __raygen__camera() {
    const uint3 idx = optixGetLaunchIndex();
    const uint3 dim = optixGetLaunchDimensions();
    const unsigned pixel = idx.y * params.width + idx.x;
    unsigned seed = hashPcg(pixel);
    const float3 direction =
        cameraDirection(params.camera, (idx.x + nextFloat(seed)) / static_cast<float>(dim.x),
                        (idx.y + nextFloat(seed)) / static_cast<float>(dim.y));
    unsigned p0 = 0, p1 = 0, p2 = 0;
    optixTrace(params.handle, params.camera.eye, direction, 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_NONE, 0, 2, 0, p0, p1, p2);
    const float3 c = vec(__uint_as_float(p0), __uint_as_float(p1), __uint_as_float(p2));
    params.image[pixel] = withWeight(c, 1.0f);
    const auto byte = [](float x) {
        return static_cast<unsigned char>(255.0f * powf(clamp01(x), 1.0f / 2.2f));
    };
    params.colors[pixel] = make_uchar4(byte(c.x), byte(c.y), byte(c.z), 255);
}
