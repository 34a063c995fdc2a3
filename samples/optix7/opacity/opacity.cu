// SPDX-License-Identifier: Apache-2.0
// Leaves cut out of squares. The any-hit program reads the mask; it runs for every square that a
// ray meets, or, with opacity micromaps, only near the outline. The programs are the same in both
// cases. Payload values 0 to 2 carry the colour back, value 3 counts calls of the any-hit program.
#include <optix.h>

#include "params.h"

extern "C" {
__constant__ Params params;
}

#define DEVICE static __forceinline__ __device__

DEVICE void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}

DEVICE float3 skyColor(float3 direction) {
    return lerp(vec(0.98f, 0.95f, 0.88f), vec(0.4f, 0.6f, 0.92f), clamp01(direction.y * 1.6f));
}

DEVICE float3 hitPoint() {
    return optixGetWorldRayOrigin() + optixGetWorldRayDirection() * optixGetRayTmax();
}

// Light of sky and sun on a surface that is lit from both sides.
DEVICE float3 lit(float3 color, float3 normal) {
    unsigned unused0 = 0, unused1 = 0, visible = 0, calls = optixGetPayload_3();
    optixTrace(params.scene, hitPoint() + normal * 1e-3f, params.lightDirection, 1e-3f, 1e16f, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               kShadowRay, kRayTypeCount, kShadowRay, unused0, unused1, visible, calls);
    optixSetPayload_3(calls);
    const float cosine = dot(normal, params.lightDirection);
    const float3 ambient = skyColor(normal) * (0.25f + 0.15f * normal.y);
    const float3 sun = vec(1.0f, 0.93f, 0.78f) * (visible ? 1.5f * maxOf(cosine, 0.0f) : 0.0f);
    return color * (ambient + sun);
}

extern "C" __global__ void __raygen__camera() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned axis = params.samplesPerAxis;
    float3 sum = vec(0.0f);
    unsigned calls = 0;
    for (unsigned i = 0; i < axis * axis; ++i) {
        const float x = (index.x + (i % axis + 0.5f) / axis) / size.x;
        const float y = (index.y + (i / axis + 0.5f) / axis) / size.y;
        unsigned red = 0, green = 0, blue = 0;
        optixTrace(params.scene, params.camera.eye, cameraDirection(params.camera, x, y), 1e-3f,
                   1e16f, 0.0f, OptixVisibilityMask(255), OPTIX_RAY_FLAG_NONE, kRadianceRay,
                   kRayTypeCount, kRadianceRay, red, green, blue, calls);
        sum += vec(__uint_as_float(red), __uint_as_float(green), __uint_as_float(blue));
    }
    sum = sum / float(axis * axis);
    float4 pixel;
    pixel.x = sum.x;
    pixel.y = sum.y;
    pixel.z = sum.z;
    pixel.w = float(calls);
    params.image[index.y * size.x + index.x] = pixel;
}

extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()));
}

extern "C" __global__ void __miss__shadow() {
    optixSetPayload_2(1);
}

extern "C" __global__ void __anyhit__mask() {
    optixSetPayload_3(optixGetPayload_3() + 1);
    const float2 uv = leafCoordinates(optixGetPrimitiveIndex(), optixGetTriangleBarycentrics());
    if (!params.mask.covers(uv.x, uv.y))
        optixIgnoreIntersection();
}

extern "C" __global__ void __closesthit__leaf() {
    const unsigned triangle = optixGetPrimitiveIndex();
    float3 normal = params.normals[triangle / 2];
    if (dot(normal, optixGetWorldRayDirection()) > 0.0f)
        normal = -normal;
    // Leaves of one plant differ a little; a vein along the middle is lighter.
    const float tint = float((triangle / 2) * 2654435761u >> 24) / 255.0f;
    float3 color = lerp(vec(0.12f, 0.36f, 0.06f), vec(0.45f, 0.55f, 0.1f), tint * tint);
    const float2 uv = leafCoordinates(triangle, optixGetTriangleBarycentrics());
    const float fromVein = uv.x > 0.5f ? uv.x - 0.5f : 0.5f - uv.x;
    if (fromVein < 0.012f)
        color = color * 1.5f;
    setColor(lit(color, normal));
}

extern "C" __global__ void __closesthit__ground() {
    const float3 color = lit(vec(0.55f, 0.5f, 0.42f), vec(0.0f, 1.0f, 0.0f));
    const float distance = optixGetRayTmax();
    setColor(lerp(color, skyColor(optixGetWorldRayDirection()), distance / (distance + 60.0f)));
}
