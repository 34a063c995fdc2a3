// SPDX-License-Identifier: Apache-2.0
// Triangles, boxes of an intersection program, curves and spheres in one structure of instances:
// rays, and the first two shapes; mixed_shapes_round.cu has the others.
#include "mixed_payload.h"

extern "C" {
__constant__ MixedParams params;
}

extern "C" __global__ void __closesthit__mesh() {
    const MixedRecord* r = mixedRecord();
    const uint3 t = r->mesh.indices[optixGetPrimitiveIndex()];
    const float3 a = r->mesh.vertices[t.x];
    setMixedHit(cross(r->mesh.vertices[t.y] - a, r->mesh.vertices[t.z] - a), r->color);
}

extern "C" __global__ void __intersection__box() {
    const MixedBox& box = mixedRecord()->boxes[optixGetPrimitiveIndex()];
    const float3 o = optixGetObjectRayOrigin() - box.center, d = optixGetObjectRayDirection();
    const float3 slope = vec(1.0f / d.x, 1.0f / d.y, 1.0f / d.z);
    const float3 middle = o * slope;
    const float3 span = vec(fabsf(slope.x), fabsf(slope.y), fabsf(slope.z)) * box.half;
    const float3 in = -middle - span, out = span - middle;
    const float enter = fmaxf(in.x, fmaxf(in.y, in.z)), leave = fminf(out.x, fminf(out.y, out.z));
    if (enter >= leave)
        return;
    const auto sideOf = [&](float3 limit, float t, float sign) {
        return vec(limit.x == t ? sign * copysignf(1.0f, d.x) : 0.0f,
                   limit.y == t ? sign * copysignf(1.0f, d.y) : 0.0f,
                   limit.z == t ? sign * copysignf(1.0f, d.z) : 0.0f);
    };
    const auto report = [&](float t, float3 n) {
        return t > optixGetRayTmin() && t < optixGetRayTmax() &&
               optixReportIntersection(t, 0, __float_as_uint(n.x), __float_as_uint(n.y),
                                       __float_as_uint(n.z));
    };
    if (!report(enter, sideOf(in, enter, -1.0f)))
        report(leave, sideOf(out, leave, 1.0f));
}
extern "C" __global__ void __closesthit__box() {
    setMixedHit(vec(__uint_as_float(optixGetAttribute_0()), __uint_as_float(optixGetAttribute_1()),
                    __uint_as_float(optixGetAttribute_2())),
                mixedRecord()->color);
}

extern "C" __global__ void __miss__surface() {
    mixedHit()->distance = -1.0f;
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

DEVICE bool isOpen(float3 origin, float3 direction, float reach) {
    unsigned open = 0, unused = 0;
    optixTrace(params.handle, origin, direction, 2e-3f, reach, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, open, unused);
    return open != 0;
}

extern "C" __global__ void __raygen__mixed() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    const float3 direction = cameraDirection(params.camera, (index.x + nextFloat(random)) / size.x,
                                             (index.y + nextFloat(random)) / size.y);
    MixedHit hit;
    const unsigned long long address = reinterpret_cast<unsigned long long>(&hit);
    unsigned low = static_cast<unsigned>(address), high = static_cast<unsigned>(address >> 32);
    optixTrace(params.handle, params.camera.eye, direction, 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, low, high);
    float3 color = blueSky(direction);
    if (hit.distance >= 0.0f) {
        const float3 point = hit.point + hit.normal * 2e-3f;
        unsigned open = 0;
        for (unsigned i = 0; i < params.occlusionRays; ++i) {
            const float u = nextFloat(random), v = nextFloat(random);
            open += isOpen(point, cosineDirection(hit.normal, u, v), params.reach);
        }
        float3 light = blueSky(hit.normal) * (0.6f * open / params.occlusionRays);
        const float cosine = dot(hit.normal, params.sun);
        if (cosine > 0.0f && isOpen(point, params.sun, 1e16f))
            light += vec(1.3f, 1.2f, 1.0f) * cosine;
        color = hit.color * light;
    }
    params.image[pixel] = withWeight(color, 1.0f);
}
