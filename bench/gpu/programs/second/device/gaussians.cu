// SPDX-License-Identifier: Apache-2.0
// Gaussians inside icosahedra. An any-hit program keeps the 16 nearest in 32 payload words, sorted
// by the distance where the ray enters the icosahedron; the ray generation program blends them and
// traces the next round behind the last.
#include "gaussians.h"
#include "tools.h"

extern "C" {
__constant__ GaussianParams params;
}

constexpr int kKept = 16;
constexpr unsigned kFaces = 20;

#define KEEP(d, n)                                                                                 \
    {                                                                                              \
        const float other = __uint_as_float(optixGetPayload_##d());                                \
        if (distance < other) {                                                                    \
            const unsigned otherNumber = optixGetPayload_##n();                                    \
            optixSetPayload_##d(__float_as_uint(distance));                                        \
            optixSetPayload_##n(number);                                                           \
            distance = other;                                                                      \
            number = otherNumber;                                                                  \
        }                                                                                          \
    }

extern "C" __global__ void __anyhit__keep() {
    float distance = optixGetRayTmax();
    unsigned number = optixGetPrimitiveIndex() / kFaces;
    // A hit behind the last of a full list ends the ray's interval.
    if (distance >= __uint_as_float(optixGetPayload_30()))
        return;
    KEEP(0, 1)
    KEEP(2, 3)
    KEEP(4, 5)
    KEEP(6, 7)
    KEEP(8, 9)
    KEEP(10, 11)
    KEEP(12, 13)
    KEEP(14, 15)
    KEEP(16, 17)
    KEEP(18, 19)
    KEEP(20, 21)
    KEEP(22, 23)
    KEEP(24, 25)
    KEEP(26, 27)
    KEEP(28, 29)
    KEEP(30, 31)
    optixIgnoreIntersection();
}

DEVICE float3 toOwnSpace(const Gaussian& g, float3 v, float w) {
    return vec(g.rows[0].x * v.x + g.rows[0].y * v.y + g.rows[0].z * v.z + g.rows[0].w * w,
               g.rows[1].x * v.x + g.rows[1].y * v.y + g.rows[1].z * v.z + g.rows[1].w * w,
               g.rows[2].x * v.x + g.rows[2].y * v.y + g.rows[2].z * v.z + g.rows[2].w * w);
}

// The share of light that the Gaussian's densest point on the ray holds back.
DEVICE float alphaOf(const Gaussian& g, float3 origin, float3 direction) {
    const float3 o = toOwnSpace(g, origin, 1.0f), d = toOwnSpace(g, direction, 0.0f);
    const float3 nearest = o - d * (dot(o, d) / dot(d, d));
    return fminf(0.99f, g.color.w * __expf(-0.5f * dot(nearest, nearest)));
}
DEVICE float3 colorOf(const Gaussian& g, float3 d) {
    const auto channel = [&](float base, float4 t) {
        return fmaxf(base + t.x * d.x + t.y * d.y + t.z * d.z, 0.0f);
    };
    return vec(channel(g.color.x, g.tint[0]), channel(g.color.y, g.tint[1]),
               channel(g.color.z, g.tint[2]));
}

DEVICE void traceRound(float3 origin, float3 direction, float from, unsigned (&w)[2 * kKept]) {
#pragma unroll
    for (int i = 0; i < kKept; ++i) {
        w[2 * i] = __float_as_uint(1e20f);
        w[2 * i + 1] = ~0u;
    }
    optixTrace(params.handle, origin, direction, from, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT | OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES, 0, 1,
               0, w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7], w[8], w[9], w[10], w[11], w[12],
               w[13], w[14], w[15], w[16], w[17], w[18], w[19], w[20], w[21], w[22], w[23], w[24],
               w[25], w[26], w[27], w[28], w[29], w[30], w[31]);
}

extern "C" __global__ void __raygen__gaussians() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const float3 origin = params.camera.eye;
    const float3 direction =
        cameraDirection(params.camera, (index.x + 0.5f) / size.x, (index.y + 0.5f) / size.y);
    float3 light = vec(0.0f);
    float transmittance = 1.0f, from = 0.0f;
    for (unsigned round = 0; round < params.maxRounds; ++round) {
        unsigned kept[2 * kKept];
        traceRound(origin, direction, from, kept);
#pragma unroll
        for (int i = 0; i < kKept; ++i) {
            if (kept[2 * i + 1] == ~0u || transmittance < params.leastTransmittance)
                continue;
            const Gaussian& g = params.gaussians[kept[2 * i + 1]];
            const float alpha = alphaOf(g, origin, direction);
            light += colorOf(g, direction) * (transmittance * alpha);
            transmittance *= 1.0f - alpha;
        }
        if (kept[31] == ~0u || transmittance < params.leastTransmittance)
            break;
        from = __uint_as_float(kept[30]) * 1.000001f;
    }
    light += blueSky(direction) * transmittance;
    params.image[index.y * size.x + index.x] = withWeight(light, 1.0f - transmittance);
}
