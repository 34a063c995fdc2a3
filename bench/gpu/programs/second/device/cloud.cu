// SPDX-License-Identifier: Apache-2.0
// A cloud above a landscape: the ray generation program finds the next event of a path by delta
// tracking through a 3D texture, between traces for the surfaces. Payload: normal, distance,
// albedo.
#include "cloud.h"
#include "tools.h"

extern "C" {
__constant__ CloudParams params;
}

struct Surface {
    float3 normal, albedo;
    float distance; // negative: none
};

DEVICE Surface findSurface(float3 origin, float3 direction) {
    unsigned p[7] = {};
    optixTrace(params.ground, origin, direction, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, p[0], p[1], p[2], p[3], p[4], p[5], p[6]);
    Surface s;
    s.normal = vec(__uint_as_float(p[0]), __uint_as_float(p[1]), __uint_as_float(p[2]));
    s.distance = __uint_as_float(p[3]);
    s.albedo = vec(__uint_as_float(p[4]), __uint_as_float(p[5]), __uint_as_float(p[6]));
    return s;
}
DEVICE bool reachesSun(float3 origin) {
    unsigned p[7] = {1u};
    optixTrace(params.ground, origin, params.sun, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, p[0], p[1], p[2], p[3], p[4], p[5], p[6]);
    return p[0] == 0u;
}

extern "C" __global__ void __closesthit__ground() {
    const GroundRecord* r = reinterpret_cast<const GroundRecord*>(optixGetSbtDataPointer());
    const uint3 t = r->indices[optixGetPrimitiveIndex()];
    const float3 a = r->vertices[t.x];
    const float3 normal = towardsRay(normalize(cross(r->vertices[t.y] - a, r->vertices[t.z] - a)));
    const float3 albedo = r->albedo * (0.6f + 0.4f * fabsf(normal.y));
    optixSetPayload_0(__float_as_uint(normal.x));
    optixSetPayload_1(__float_as_uint(normal.y));
    optixSetPayload_2(__float_as_uint(normal.z));
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_4(__float_as_uint(albedo.x));
    optixSetPayload_5(__float_as_uint(albedo.y));
    optixSetPayload_6(__float_as_uint(albedo.z));
}
extern "C" __global__ void __miss__far() {
    optixSetPayload_3(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__sun() {
    optixSetPayload_0(0u);
}

// ---- The cloud ----------------------------------------------------------------------------------

DEVICE float densityAt(float3 p) {
    const float3 size = params.high - params.low, q = p - params.low;
    return tex3D<float>(params.density, q.x / size.x, q.y / size.y, q.z / size.z);
}
// The part of a ray inside the box.
DEVICE bool clip(float3 o, float3 d, float& from, float& to) {
    const float ox[3] = {o.x, o.y, o.z}, dx[3] = {d.x, d.y, d.z};
    const float low[3] = {params.low.x, params.low.y, params.low.z};
    const float high[3] = {params.high.x, params.high.y, params.high.z};
    for (int i = 0; i < 3; ++i) {
        const float a = (low[i] - ox[i]) / dx[i], b = (high[i] - ox[i]) / dx[i];
        from = fmaxf(from, fminf(a, b));
        to = fminf(to, fmaxf(a, b));
    }
    return from < to;
}
// The distance to the next collision, or -1.
DEVICE float collide(float3 o, float3 d, float from, float to, unsigned& random) {
    float t = from;
    while (true) {
        t -= __logf(1.0f - nextFloat(random)) / params.extinction;
        if (t >= to)
            return -1.0f;
        if (nextFloat(random) < densityAt(o + d * t))
            return t;
    }
}
// An estimate of the share of light that passes.
DEVICE float passes(float3 o, float3 d, unsigned& random) {
    float from = 0.0f, to = 1e16f, share = 1.0f;
    if (!clip(o, d, from, to))
        return 1.0f;
    for (float t = from; share > 0.0f;) {
        t -= __logf(1.0f - nextFloat(random)) / params.extinction;
        if (t >= to)
            break;
        share *= 1.0f - densityAt(o + d * t);
        if (share < 0.05f) { // ends dim paths without bias
            if (nextFloat(random) < 0.5f)
                return 0.0f;
            share *= 2.0f;
        }
    }
    return share;
}
DEVICE float phase(float cosine) {
    const float g = params.forward, base = 1.0f + g * g - 2.0f * g * cosine;
    return (1.0f - g * g) / (4.0f * kPi * base * sqrtf(base));
}
DEVICE float3 scatter(float3 d, unsigned& random) {
    const float g = params.forward, u = nextFloat(random), v = nextFloat(random);
    const float part = (1.0f - g * g) / (1.0f - g + 2.0f * g * u);
    const float cosine = (1.0f + g * g - part * part) / (2.0f * g);
    const float sine = sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f));
    const float2 c = circlePoint(v);
    float3 x, y;
    makeBasis(d, x, y);
    return normalize(fromBasis(x, y, d, vec(sine * c.x, sine * c.y, cosine)));
}

extern "C" __global__ void __raygen__cloud() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 o = params.camera.eye;
    float3 d = cameraDirection(params.camera, (index.x + nextFloat(random)) / size.x,
                               (index.y + nextFloat(random)) / size.y);
    float3 light = vec(0.0f), throughput = vec(1.0f);
    for (unsigned event = 0; event < params.maxEvents; ++event) {
        const Surface surface = findSurface(o, d);
        float from = 0.0f, to = surface.distance < 0.0f ? 1e16f : surface.distance;
        const float t = clip(o, d, from, to) ? collide(o, d, from, to, random) : -1.0f;
        if (t >= 0.0f) {
            o = o + d * t;
            throughput *= vec(0.995f, 0.995f, 0.998f);
            if (reachesSun(o))
                light += throughput * params.sunlight *
                         (phase(dot(d, params.sun)) * passes(o, params.sun, random));
            d = scatter(d, random);
        } else if (surface.distance >= 0.0f) {
            o = o + d * surface.distance + surface.normal * 1e-3f;
            throughput *= surface.albedo;
            const float cosine = dot(surface.normal, params.sun);
            if (cosine > 0.0f && reachesSun(o))
                light +=
                    throughput * params.sunlight * (cosine / kPi * passes(o, params.sun, random));
            const float u = nextFloat(random), v = nextFloat(random);
            d = cosineDirection(surface.normal, u, v);
        } else {
            light += throughput * blueSky(d);
            break;
        }
        const float stays = fminf(maxComponent(throughput), 1.0f);
        if (event > 4 && nextFloat(random) >= stays)
            break;
        throughput = event > 4 ? throughput / stays : throughput;
    }
    params.image[pixel] = withWeight(light, 1.0f);
}
