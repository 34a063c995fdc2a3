// SPDX-License-Identifier: Apache-2.0
#include <optix.h>

#include "brick_volume.h"

extern "C" __constant__ Params params;

static __forceinline__ __device__ float3 at(float3 o, float3 d, float t) {
    return make_float3(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
}
static __forceinline__ __device__ float sample(const Brick& b, float3 p) {
    const float scale = (b.texels - 1) / b.size;
    return tex3D<float>(b.distances, (p.x - b.low.x) * scale + 0.5f, (p.y - b.low.y) * scale + 0.5f,
                        (p.z - b.low.z) * scale + 0.5f);
}

extern "C" __global__ void __raygen__view() {
    const uint3 i = optixGetLaunchIndex();
    unsigned p[4] = {0, 0, 0, 0};
    optixTrace(params.scene,
               make_float3(2.4f * (i.x + 0.5f) / params.width - 1.2f,
                           2.4f * (i.y + 0.5f) / params.height - 1.2f, 3.0f),
               make_float3(0, 0, -1), 0, 100, 0, 255, OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, p[0],
               p[1], p[2], p[3]);
    params.out[i.y * params.width + i.x] = make_float4(
        __uint_as_float(p[0]), __uint_as_float(p[1]), __uint_as_float(p[2]), __uint_as_float(p[3]));
}
// Each brick is a primitive with a record of its own: marches spheres through the texture.
extern "C" __global__ void __intersection__march() {
    const Brick& b = *reinterpret_cast<const Brick*>(optixGetSbtDataPointer());
    const float3 o = optixGetWorldRayOrigin(), d = optixGetWorldRayDirection();
    // The ray goes along z.
    const float begin = o.z - (b.low.z + b.size), end = o.z - b.low.z;
    const int x = int((o.x - b.low.x) / b.size * 8), y = int((o.y - b.low.y) / b.size * 8);
    if (x >= 0 && x < 8 && y >= 0 && y < 8)
        surf2Dwrite<int>(1, b.visits, x * 4, y);
    float t = begin;
    for (int step = 0; step < 96 && t <= end; ++step) {
        const float distance = sample(b, at(o, d, t));
        if (distance < 1e-4f) {
            optixReportIntersection(t, step & 63);
            return;
        }
        t += distance;
    }
}
extern "C" __global__ void __closesthit__surface() {
    const Brick& b = *reinterpret_cast<const Brick*>(optixGetSbtDataPointer());
    const float t = optixGetRayTmax(), h = 0.5f * b.size / b.texels;
    const float3 p = at(optixGetWorldRayOrigin(), optixGetWorldRayDirection(), t);
    const float3 n = make_float3(
        sample(b, make_float3(p.x + h, p.y, p.z)) - sample(b, make_float3(p.x - h, p.y, p.z)),
        sample(b, make_float3(p.x, p.y + h, p.z)) - sample(b, make_float3(p.x, p.y - h, p.z)),
        sample(b, make_float3(p.x, p.y, p.z + h)) - sample(b, make_float3(p.x, p.y, p.z - h)));
    const float scale = rsqrtf(fmaxf(1e-20f, n.x * n.x + n.y * n.y + n.z * n.z));
    optixSetPayload_0(__float_as_uint(n.x * scale));
    optixSetPayload_1(__float_as_uint(n.y * scale));
    optixSetPayload_2(__float_as_uint(n.z * scale));
    optixSetPayload_3(__float_as_uint(t));
}
extern "C" __global__ void __miss__sky() {
    const float3 o = optixGetWorldRayOrigin();
    const float4 colour = tex2D<float4>(params.sky, o.x * 0.5f + 0.013f, o.y * 0.5f);
    optixSetPayload_0(__float_as_uint(colour.x));
    optixSetPayload_1(__float_as_uint(colour.y));
    optixSetPayload_2(__float_as_uint(colour.z));
    optixSetPayload_3(__float_as_uint(-colour.w));
}
