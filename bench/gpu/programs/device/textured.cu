// SPDX-License-Identifier: Apache-2.0
// A path tracer with textures: three reads a hit, then a direct callable per material, MATERIALS of
// them, which chooses the next direction. With SHADERS a closest-hit program per material in place
// of the callables. Payload: the address of the path.
#include "common.h"

struct Path {
    float3 origin, direction, throughput, radiance;
    unsigned random, depth, done;
};
DEVICE Path& pathOf() {
    return *reinterpret_cast<Path*>((unsigned long long)(optixGetPayload_1()) << 32 |
                                    optixGetPayload_0());
}
DEVICE bool sees(float3 origin, float3 direction, float distance) {
    unsigned hidden = 1, no = 0;
    optixTrace(params.scene, origin, direction, 0.0f, distance, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hidden, no);
    return hidden == 0;
}

// Input and output of a material.
struct Shading {
    float3 incoming, normal, albedo;
    float roughness, u, v;
};
struct Scattered {
    float3 direction, weight;
    float matt; // share of light from the lamp
};

// Materials are blends of a diffuse and a glossy lobe with a sheen, in shares of their own.
template <unsigned N>
DEVICE Scattered scatter(const Shading& s) {
    constexpr unsigned kHash = (N * 2654435761u) >> 16;
    constexpr float kGloss = 0.1f + 0.6f * float(kHash & 255) / 255.0f;
    constexpr float kSheen = 0.3f * float((kHash >> 4) & 255) / 255.0f;
    Scattered out;
    const float3 mirrored = reflect(s.incoming, s.normal);
    const float3 around = cosineDirection(s.normal, s.u, s.v);
    const float cosine = maxOf(-dot(s.incoming, s.normal), 0.0f);
    const float edge = (1 - cosine) * (1 - cosine) * (1 - cosine) * (1 - cosine) * (1 - cosine);
    const float chance = kGloss * (0.2f + 0.8f * edge);
    const bool isGlossy = s.u * 7.0f - floorf(s.u * 7.0f) < chance;
    out.direction =
        isGlossy ? normalize(lerp(mirrored, around, s.roughness * s.roughness)) : around;
    out.weight = isGlossy ? vec(0.9f) : s.albedo * (1.0f + kSheen * edge);
    if (N % 3 == 1) // an anisotropic highlight
        out.weight = out.weight * (0.8f + 0.2f * fabsf(out.direction.x));
    if (N % 3 == 2) // a thin film
        out.weight = out.weight * vec(0.8f + 0.2f * circlePoint(0.9f * cosine).x,
                                      0.8f + 0.2f * circlePoint(0.7f * cosine).x,
                                      0.8f + 0.2f * circlePoint(0.5f * cosine).x);
    out.matt = isGlossy ? 0.0f : 1.0f;
    return out;
}
// Texture coordinates from the triangle's plane, because the mesh has none.
DEVICE float2 textureCoordinates(float3 point, float3 normal) {
    float3 x, y;
    makeBasis(normal, x, y);
    return make_float2(dot(point, x) * 1.7f, dot(point, y) * 1.7f);
}

template <class Scatter>
DEVICE void shade(const Scatter& scatterAt) {
    Path& path = pathOf();
    const Look& m = material();
    bool back;
    float3 normal = facing(triangleNormal(), back);
    const float3 point = hitPoint();
    if (m.surface == kLamp) {
        if (path.depth == 0)
            path.radiance += params.emission;
        path.done = 1;
        return;
    }
    const float2 uv = textureCoordinates(point, normal);
    const float4 albedo = tex2D<float4>(m.textures[0], uv.x, uv.y);
    const float rough = tex2D<float4>(m.textures[1], uv.x, uv.y).x;
    const float4 bump = tex2D<float4>(m.textures[2], uv.x, uv.y);
    float3 x, y;
    makeBasis(normal, x, y);
    normal = normalize(normal + x * (0.4f * (bump.x - 0.5f)) + y * (0.4f * (bump.y - 0.5f)));
    Shading s = {optixGetWorldRayDirection(), normal, vec(albedo.x, albedo.y, albedo.z) * m.color,
                 0.05f + 0.9f * rough,        0,      0};
    s.u = nextFloat(path.random);
    s.v = nextFloat(path.random);
    const Scattered b = scatterAt(m, s);
    const float3 above = point + normal * params.epsilon;
    path.throughput = path.throughput * b.weight;
    if (b.matt > 0.0f) {
        const LampSample lamp = sampleLamp(point, normal, path.random);
        if (maxComponent(lamp.light) > 0.0f &&
            sees(above, lamp.direction, lamp.distance - 2 * params.epsilon))
            path.radiance += path.throughput * lamp.light * b.matt;
    }
    path.origin = above;
    path.direction = b.direction;
    ++path.depth;
}

#ifdef SHADERS
#define MATERIAL(n)                                                                                \
    extern "C" __global__ void __closesthit__##n() {                                               \
        shade([](const Look&, const Shading& s) { return scatter<n>(s); });                        \
    }
#else
#define MATERIAL(n)                                                                                \
    extern "C" __device__ Scattered __direct_callable__##n(Shading s) {                            \
        return scatter<n>(s);                                                                      \
    }
extern "C" __global__ void __closesthit__textured() {
    shade([](const Look& m, const Shading& s) {
        return optixDirectCall<Scattered, Shading>(m.callable, s);
    });
}
#endif
#include "materials.h"

extern "C" __global__ void __miss__sky() {
    Path& path = pathOf();
    path.radiance += path.throughput * skyColor(optixGetWorldRayDirection());
    path.done = 1;
}
extern "C" __global__ void __miss__lamp() {
    optixSetPayload_0(0);
}
extern "C" __global__ void __raygen__paths() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i) {
        Path path = {params.camera.eye, cameraRay(random), vec(1.0f), vec(0.0f), random, 0, 0};
        const unsigned long long address = reinterpret_cast<unsigned long long>(&path);
        for (unsigned depth = 0; depth < params.depth && !path.done; ++depth) {
            unsigned low = unsigned(address), high = unsigned(address >> 32);
            optixTrace(params.scene, path.origin, path.direction, 0.0f, 1e16f, 0.0f,
                       OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, low, high);
        }
        sum += path.radiance;
        random = path.random + 1;
    }
    store(sum / float(params.samples));
}
