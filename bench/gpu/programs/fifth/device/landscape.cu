// SPDX-License-Identifier: Apache-2.0
// Water, sand, grass, rock and snow of one structure of triangles. Ray generation follows a path; a
// continuation callable of the ground's cover traces rays to the sun and to the sky, and chooses
// where the path goes on. Payload: distance, normal; of short rays whether they are open.
#include "landscape.h"
#include "tools.h"

extern "C" {
__constant__ LandscapeParams params;
}

struct LandPoint {
    float distance; // negative: none
    float3 at, normal, eye;
};
struct LandStep {
    float3 light; // that leaves towards the eye
    float3 share; // of the light that arrives along the next direction
    float3 origin, next;
};

extern "C" __global__ void __closesthit__land() {
    const auto* r = reinterpret_cast<const LandscapeRecord*>(optixGetSbtDataPointer());
    const uint3 t = r->mesh.indices[optixGetPrimitiveIndex()];
    const float2 b = optixGetTriangleBarycentrics();
    const float3 normal = towardsRay(normalize(r->normals[t.x] * (1.0f - b.x - b.y) +
                                               r->normals[t.y] * b.x + r->normals[t.z] * b.y));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(__float_as_uint(normal.x));
    optixSetPayload_2(__float_as_uint(normal.y));
    optixSetPayload_3(__float_as_uint(normal.z));
}
extern "C" __global__ void __miss__sky() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

DEVICE LandPoint find(float3 from, float3 direction) {
    unsigned distance, x, y, z;
    optixTrace(params.land, from, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, distance, x, y, z);
    LandPoint p;
    p.distance = __uint_as_float(distance);
    p.normal = vec(__uint_as_float(x), __uint_as_float(y), __uint_as_float(z));
    p.at = from + direction * p.distance + p.normal * 3e-3f;
    p.eye = -direction;
    return p;
}
DEVICE bool isOpen(float3 from, float3 direction, float reach) {
    unsigned open = 0, unused = 0;
    optixTrace(params.land, from, direction, 1e-3f, reach, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, open, unused, unused, unused);
    return open != 0;
}
DEVICE float3 skyTowards(float3 direction) {
    const float height = fmaxf(direction.y, 0.0f);
    const float towards = fmaxf(dot(direction, params.sun), 0.0f);
    return lerp(vec(0.9f, 0.75f, 0.6f), vec(0.2f, 0.38f, 0.75f), sqrtf(height)) +
           vec(1.0f, 0.6f, 0.25f) * (0.6f * powf(towards, 16.0f));
}
DEVICE float3 sunAt(const LandPoint& p, float3 normal) {
    const float cosine = dot(normal, params.sun);
    return cosine > 0.0f && isOpen(p.at, params.sun, 1e16f) ? vec(2.3f, 1.9f, 1.4f) * cosine
                                                            : vec(0.0f);
}
// The share of short rays that meet nothing.
DEVICE float openness(const LandPoint& p, unsigned rays, float reach, unsigned& random) {
    unsigned open = 0;
    for (unsigned i = 0; i < rays; ++i) {
        const float u = nextFloat(random), v = nextFloat(random);
        open += isOpen(p.at, cosineDirection(p.normal, u, v), reach);
    }
    return static_cast<float>(open) / rays;
}
DEVICE LandStep scattered(const LandPoint& p, float3 color, float3 light, unsigned& random) {
    const float u = nextFloat(random), v = nextFloat(random);
    return {color * light, color, p.at, cosineDirection(p.normal, u, v)};
}
// Smooth noise of a place, from 0 to 1.
DEVICE float mottle(float3 p, float scale) {
    return 0.5f + 0.25f * (sinf(scale * p.x + 2.0f * sinf(0.7f * scale * p.z)) +
                           sinf(scale * p.z + 2.0f * sinf(0.6f * scale * p.x)));
}

extern "C" __device__ LandStep __continuation_callable__water(const LandPoint& p,
                                                              unsigned& random) {
    const float fade = 0.06f / (1.0f + 0.05f * p.distance);
    const float3 normal = normalize(vec(fade * (sinf(9.0f * p.at.x + 5.0f * p.at.z)), 1.0f,
                                        fade * sinf(7.0f * p.at.z - 4.0f * p.at.x)));
    float3 next = reflect(-p.eye, normal);
    next.y = fabsf(next.y);
    const float edge = clamp01(1.0f - dot(p.eye, normal)), squared = edge * edge;
    const float glint = 30.0f * powf(fmaxf(dot(next, params.sun), 0.0f), 900.0f);
    const float3 sun = sunAt(p, normal);
    const float wave = nextFloat(random) * 0.02f;
    return {vec(0.02f, 0.09f, 0.1f) * (sun + vec(0.4f + wave)) + sun * glint,
            vec(0.03f + 0.97f * squared * squared * edge), p.at, next};
}
extern "C" __device__ LandStep __continuation_callable__sand(const LandPoint& p, unsigned& random) {
    const float3 ripples = normalize(
        p.normal + vec(0.15f * sinf(25.0f * p.at.x + 6.0f * sinf(2.0f * p.at.z)), 0.0f, 0.0f));
    const float open = openness(p, 1, 0.5f, random);
    return scattered(p, vec(0.6f, 0.5f, 0.34f), sunAt(p, ripples) + vec(0.05f * open), random);
}
extern "C" __device__ LandStep __continuation_callable__grass(const LandPoint& p,
                                                              unsigned& random) {
    const float3 color = lerp(vec(0.13f, 0.22f, 0.05f), vec(0.3f, 0.33f, 0.1f), mottle(p.at, 3.0f));
    const float open = openness(p, 3, 0.8f, random);
    return scattered(p, color, (sunAt(p, p.normal) + vec(0.1f)) * (0.35f + 0.65f * open), random);
}
extern "C" __device__ LandStep __continuation_callable__rock(const LandPoint& p, unsigned& random) {
    const float bands = mottle(vec(0.2f * p.at.x, 0.0f, 6.0f * p.at.y), 2.0f);
    const float3 color = lerp(vec(0.25f, 0.22f, 0.2f), vec(0.45f, 0.38f, 0.33f), bands);
    const float open = openness(p, 2, 1.5f, random);
    return scattered(p, color, sunAt(p, p.normal) + vec(0.08f * open), random);
}
// Light from around the place, as if the snow passed it on.
extern "C" __device__ LandStep __continuation_callable__snow(const LandPoint& p, unsigned& random) {
    const float u = nextFloat(random), v = nextFloat(random);
    const float3 softer = normalize(p.normal + cosineDirection(p.normal, u, v) * 0.6f);
    const float3 light = sunAt(p, p.normal) * 0.6f + sunAt(p, softer) * 0.4f;
    return scattered(p, vec(0.82f, 0.85f, 0.9f), light, random);
}

DEVICE unsigned coverOf(const LandPoint& p) {
    const float edge = mottle(p.at, 1.3f) + 0.3f * mottle(p.at, 7.0f);
    if (p.at.y < 0.01f)
        return kWaterCover;
    if (p.normal.y < 0.56f + 0.08f * edge)
        return kRockCover;
    if (p.at.y < 0.2f + 0.3f * edge)
        return kSandCover;
    return p.at.y > 3.4f + 1.2f * edge ? kSnowCover : kGrassCover;
}

extern "C" __global__ void __raygen__landscape() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        float3 origin = params.camera.eye, direction = cameraDirection(params.camera, x, y);
        float3 share = vec(1.0f);
        for (unsigned bounce = 0; bounce <= params.bounces; ++bounce) {
            const LandPoint p = find(origin, direction);
            if (p.distance < 0.0f) {
                sum += share * skyTowards(direction);
                break;
            }
            const LandStep step =
                optixContinuationCall<LandStep, const LandPoint&, unsigned&>(coverOf(p), p, random);
            sum += share * step.light;
            share = share * step.share;
            origin = step.origin;
            direction = step.next;
        }
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
