// SPDX-License-Identifier: Apache-2.0
// Cloth on a ball above a mirror. The closest-hit program traces a shadow ray and a reflected ray.
// Payload: colour and depth; for shadow rays the first word.
#include "cloth.h"
#include "tools.h"

extern "C" {
__constant__ ClothParams params;
}

constexpr unsigned kMaxDepth = 2;

DEVICE float3 traceColor(float3 origin, float3 direction, unsigned depth) {
    unsigned r, g, b;
    optixTrace(params.scene, origin, direction, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, r, g, b, depth);
    return vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
}
DEVICE void setColor(float3 c) {
    optixSetPayload_0(__float_as_uint(c.x));
    optixSetPayload_1(__float_as_uint(c.y));
    optixSetPayload_2(__float_as_uint(c.z));
}

extern "C" __global__ void __closesthit__cloth() {
    const ClothRecord& r = *reinterpret_cast<const ClothRecord*>(optixGetSbtDataPointer());
    const uint3 t = r.indices[optixGetPrimitiveIndex()];
    const float2 b = optixGetTriangleBarycentrics();
    float3 normal;
    if (r.normals)
        normal = r.normals[t.x] * (1.0f - b.x - b.y) + r.normals[t.y] * b.x + r.normals[t.z] * b.y;
    else
        normal = cross(r.vertices[t.y] - r.vertices[t.x], r.vertices[t.z] - r.vertices[t.x]);
    normal = towardsRay(normalize(normal));
    const float3 direction = optixGetWorldRayDirection();
    const float3 point = rayPoint() + normal * 3e-3f;
    const unsigned depth = optixGetPayload_3();
    float3 light = blueSky(normal) * 0.35f;
    const float cosine = dot(normal, params.sun);
    if (cosine > 0.0f) {
        unsigned hidden = 1, unused = 0;
        optixTrace(params.scene, point, params.sun, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                       OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
                   0, 1, 1, hidden, unused, unused, unused);
        if (!hidden)
            light += vec(1.3f, 1.2f, 1.0f) * cosine;
    }
    const float edge = 1.0f + dot(direction, normal);
    const float share = r.mirror + (1.0f - r.mirror) * 0.5f * edge * edge * edge;
    float3 color = r.color * light * (1.0f - share);
    if (depth < kMaxDepth)
        color += traceColor(point, reflect(direction, normal), depth + 1) * share;
    setColor(color);
}
extern "C" __global__ void __miss__sky() {
    setColor(blueSky(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__sun() {
    optixSetPayload_0(0);
}

extern "C" __global__ void __raygen__cloth() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const float3 direction =
        cameraDirection(params.camera, (index.x + 0.5f) / size.x, (index.y + 0.5f) / size.y);
    params.image[index.y * size.x + index.x] =
        withWeight(traceColor(params.camera.eye, direction, 1), 1.0f);
}
