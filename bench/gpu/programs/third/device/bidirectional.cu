// SPDX-License-Identifier: Apache-2.0
// Bidirectional path tracing with the balance heuristic (Georgiev 2012, without merging). The lamp
// is no geometry, so no camera path hits it. Payload: the address of a surface in two words; for
// shadow rays one word.
#include "bidirectional.h"
#include "tools.h"

extern "C" {
__constant__ BidirectionalParams params;
}

struct Surface {
    float3 point, normal, albedo;
    bool isMirror, isHit;
};
struct Path {
    float3 origin, direction, throughput;
    float last, earlier;
    unsigned random;
};

static __forceinline__ __device__ void* unpackPointer(unsigned i0, unsigned i1) {
    const unsigned long long uptr = static_cast<unsigned long long>(i0) << 32 | i1;
    return reinterpret_cast<void*>(uptr);
}
static __forceinline__ __device__ void packPointer(void* ptr, unsigned& i0, unsigned& i1) {
    const unsigned long long uptr = reinterpret_cast<unsigned long long>(ptr);
    i0 = uptr >> 32;
    i1 = uptr & 0x00000000ffffffff;
}
static __forceinline__ __device__ Surface* getPRD() {
    return reinterpret_cast<Surface*>(unpackPointer(optixGetPayload_0(), optixGetPayload_1()));
}

extern "C" __global__ void __closesthit__radiance() {
    const BidirectionalRecord* rt = (const BidirectionalRecord*)optixGetSbtDataPointer();
    Surface* prd = getPRD();
    prd->normal = towardsRay(normalize(rt->mesh.normal(optixGetPrimitiveIndex())));
    prd->point = rayPoint() + prd->normal * 1e-4f;
    prd->albedo = rt->albedo;
    prd->isMirror = rt->isMirror;
    prd->isHit = true;
}
extern "C" __global__ void __miss__radiance() {
    getPRD()->isHit = false;
}
extern "C" __global__ void __closesthit__occlusion() {
    optixSetPayload_0(1u);
}
extern "C" __global__ void __miss__occlusion() {
    optixSetPayload_0(0u);
}

DEVICE void traceSurface(float3 origin, float3 direction, Surface* prd) {
    unsigned u0, u1;
    packPointer(prd, u0, u1);
    optixTrace(params.room, origin, direction, 1e-5f, 1e16f, 0.0f, OptixVisibilityMask(1),
               OPTIX_RAY_FLAG_NONE, 0, 2, 0, u0, u1);
}
DEVICE bool areConnected(float3 a, float3 b) {
    unsigned hidden = 0u;
    optixTrace(params.room, a, b - a, 1e-4f, 0.9999f, 0.0f, OptixVisibilityMask(1),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT, 1, 2, 1, hidden);
    return hidden == 0u;
}

// Sums of weights at the surface that a path has reached.
DEVICE void arrive(Path& path, const Surface& s) {
    const float3 line = s.point - path.origin;
    const float cosine = fmaxf(-dot(path.direction, s.normal), 1e-4f);
    path.last *= dot(line, line) / cosine;
    path.earlier /= cosine;
}
// Goes on in a new direction.
DEVICE void scatter(Path& path, const Surface& s) {
    const float3 incoming = path.direction;
    path.origin = s.point;
    path.throughput *= s.albedo;
    if (s.isMirror) {
        path.direction = reflect(incoming, s.normal);
        path.earlier *= fabsf(dot(path.direction, s.normal));
        path.last = 0.0f;
        return;
    }
    const float u = nextFloat(path.random), v = nextFloat(path.random);
    path.direction = cosineDirection(s.normal, u, v);
    const float density = fmaxf(dot(path.direction, s.normal), 1e-4f) / kPi;
    const float back = fmaxf(-dot(incoming, s.normal), 0.0f) / kPi;
    path.earlier = kPi * (path.earlier * back + path.last);
    path.last = 1.0f / density;
}

extern "C" __global__ void __raygen__light() {
    const unsigned index = optixGetLaunchIndex().x;
    const AreaLamp& lamp = params.lamp;
    Path path;
    path.random = hashPcg(index);
    const float a = nextFloat(path.random), b = nextFloat(path.random);
    path.origin = lamp.corner + lamp.u * a + lamp.v * b + lamp.normal * 1e-4f;
    const float u = nextFloat(path.random), v = nextFloat(path.random);
    path.direction = cosineDirection(lamp.normal, u, v);
    path.throughput = lamp.radiance * (kPi * lamp.area);
    path.last = kPi / fmaxf(dot(path.direction, lamp.normal), 1e-4f);
    path.earlier = 0.0f;
    unsigned count = 0;
    for (unsigned i = 0; i < kLightVertices; ++i) {
        Surface s;
        traceSurface(path.origin, path.direction, &s);
        if (!s.isHit)
            break;
        arrive(path, s);
        if (!s.isMirror)
            params.lightVertices[index * kLightVertices + count++] = {
                s.point,         s.normal,  s.albedo,    path.direction,
                path.throughput, path.last, path.earlier};
        scatter(path, s);
    }
    params.counts[index] = count;
}

// Light that comes to a vertex of the camera's path from a point of the lamp.
DEVICE float3 connectLamp(Path& path, const Surface& s) {
    const AreaLamp& lamp = params.lamp;
    const float a = nextFloat(path.random), b = nextFloat(path.random);
    const float3 on = lamp.corner + lamp.u * a + lamp.v * b, line = on - s.point;
    const float squared = dot(line, line);
    const float3 direction = line * rsqrtf(squared);
    const float here = dot(s.normal, direction), there = -dot(lamp.normal, direction);
    if (here <= 0.0f || there <= 0.0f || !areConnected(s.point, on))
        return vec(0.0f);
    // Emission over next event, for a step of the path that a light path makes.
    const float back = fmaxf(-dot(path.direction, s.normal), 0.0f) / kPi;
    const float other = here * there / (kPi * squared) * (path.last + back * path.earlier);
    const float3 light = lamp.radiance * s.albedo * (here * there * lamp.area / (kPi * squared));
    return path.throughput * light / (1.0f + other);
}

DEVICE float3 connectVertex(const Path& path, const Surface& s, const LightVertex& y) {
    const float3 line = y.point - s.point;
    const float squared = fmaxf(dot(line, line), 1e-4f);
    const float3 direction = line * rsqrtf(squared);
    const float here = dot(s.normal, direction), there = -dot(y.normal, direction);
    if (here <= 0.0f || there <= 0.0f || !areConnected(s.point, y.point))
        return vec(0.0f);
    const float toLight = here / kPi * there / squared, toCamera = there / kPi * here / squared;
    const float lightBack = fmaxf(-dot(y.incoming, y.normal), 0.0f) / kPi;
    const float cameraBack = fmaxf(-dot(path.direction, s.normal), 0.0f) / kPi;
    const float weight = 1.0f / (1.0f + toLight * (y.last + lightBack * y.earlier) +
                                 toCamera * (path.last + cameraBack * path.earlier));
    return path.throughput * s.albedo * y.albedo * y.throughput *
           (weight * here * there / (kPi * kPi * squared));
}

extern "C" __global__ void __raygen__camera() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned pixel = index.y * params.width + index.x;
    Path path;
    path.random = hashPcg(pixel + 0x51ed27u);
    const float x = (index.x + nextFloat(path.random)) / params.width;
    const float y = (index.y + nextFloat(path.random)) / params.height;
    path.origin = params.camera.eye;
    path.direction = cameraDirection(params.camera, x, y);
    path.throughput = vec(1.0f);
    path.last = path.earlier = 0.0f; // no light path reaches the camera itself
    const unsigned partner = hashPcg(path.random) % params.paths;
    const unsigned count = params.counts[partner];
    float3 light = vec(0.0f);
    for (unsigned i = 0; i < params.cameraVertices; ++i) {
        Surface s;
        traceSurface(path.origin, path.direction, &s);
        if (!s.isHit)
            break;
        arrive(path, s);
        if (!s.isMirror) {
            light += connectLamp(path, s);
            for (unsigned k = 0; k < count; ++k)
                light += connectVertex(path, s, params.lightVertices[partner * kLightVertices + k]);
        }
        scatter(path, s);
    }
    params.image[pixel] = withWeight(light, 1.0f);
}
