// SPDX-License-Identifier: Apache-2.0
// An any-hit program that reads an alpha texture cuts leaves out of squares. With opacity micromaps
// it runs only near the outlines. Payload: the colour.
#include "common.h"

DEVICE float3 trace(float3 origin, float3 direction) {
    unsigned r = 0, g = 0, b = 0;
    optixTrace(params.scene, origin, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_NONE, 0, 2, 0, r, g, b);
    return asFloats(r, g, b);
}
DEVICE void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}

extern "C" __global__ void __raygen__camera() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i)
        sum += trace(params.camera.eye, cameraRay(random));
    store(sum / float(params.samples));
}
extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__sun() {
    optixSetPayload_0(0);
}

// A leaf is a square of two triangles: (0,0) (1,0) (1,1) and (0,0) (1,1) (0,1).
DEVICE float2 leafCoordinates() {
    const float2 b = optixGetTriangleBarycentrics();
    return optixGetPrimitiveIndex() & 1 ? make_float2(b.x, b.x + b.y) : make_float2(b.x + b.y, b.y);
}
extern "C" __global__ void __anyhit__mask() {
    const float2 uv = leafCoordinates();
    if (tex2D<float4>(material().textures[0], uv.x, uv.y).w < 0.5f)
        optixIgnoreIntersection();
}

extern "C" __global__ void __closesthit__leaf() {
    bool back;
    const float3 normal = facing(triangleNormal(), back), point = hitPoint();
    const float2 uv = leafCoordinates();
    const float4 color = tex2D<float4>(material().textures[0], uv.x, uv.y);
    unsigned hidden = 1, no = 0;
    optixTrace(params.scene, point + normal * params.epsilon, params.light[0], 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT, 1, 2, 1,
               hidden, no, no);
    const float sun = hidden ? 0.0f : fabsf(dot(normal, params.light[0]));
    setColor(vec(color.x, color.y, color.z) * (skyColor(normal) * 0.3f + params.emission * sun));
}
