// SPDX-License-Identifier: Apache-2.0
// Carousels of triangles, spheres and quadratic curves, a part of which turns while the shutter is
// open. Ray generation follows paths with a shadow ray at each hit. Payload: distance, normal,
// colour, glow, mirror; of shadow rays whether they are open.
#include "carousels.h"
#include "tools.h"

extern "C" {
__constant__ CarouselParams params;
}

struct FairPoint {
    float distance; // negative: none
    float3 normal, color;
    float glow, mirror;
};

DEVICE const CarouselRecord& record() {
    return *reinterpret_cast<const CarouselRecord*>(optixGetSbtDataPointer());
}
DEVICE float3 xyz(float4 v) {
    return vec(v.x, v.y, v.z);
}
// `normal`: in the space of the object, of any length.
DEVICE void answer(float3 normal, float3 color) {
    normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(normal)));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(__float_as_uint(normal.x));
    optixSetPayload_2(__float_as_uint(normal.y));
    optixSetPayload_3(__float_as_uint(normal.z));
    optixSetPayload_4(__float_as_uint(color.x));
    optixSetPayload_5(__float_as_uint(color.y));
    optixSetPayload_6(__float_as_uint(color.z));
    optixSetPayload_7(__float_as_uint(record().glow));
    optixSetPayload_8(__float_as_uint(record().mirror));
}
extern "C" __global__ void __closesthit__frame() {
    answer(record().mesh.normal(optixGetPrimitiveIndex()), record().color);
}
extern "C" __global__ void __closesthit__meadow() {
    const float3 p = rayPoint();
    const float stripe = 0.5f + 0.25f * (sinf(0.8f * p.x + sinf(p.z)) + sinf(1.1f * p.z));
    answer(vec(0.0f, 1.0f, 0.0f), lerp(record().color, vec(0.5f, 0.45f, 0.3f), stripe * stripe));
}
extern "C" __global__ void __closesthit__bead() {
    float4 sphere[1];
    optixGetSphereData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                       optixGetSbtGASIndex(), 0.0f, sphere);
    answer(optixTransformPointFromWorldToObjectSpace(rayPoint()) - xyz(sphere[0]), record().color);
}
extern "C" __global__ void __closesthit__garland() {
    float4 p[3];
    optixGetQuadraticBSplineVertexData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                                       optixGetSbtGASIndex(), 0.0f, p);
    const float u = optixGetCurveParameter();
    const float3 axis = xyz(p[0]) * (0.5f - u + 0.5f * u * u) + xyz(p[1]) * (0.5f + u - u * u) +
                        xyz(p[2]) * (0.5f * u * u);
    const float3 color = optixGetPrimitiveIndex() & 1 ? record().color : vec(0.85f);
    answer(optixTransformPointFromWorldToObjectSpace(rayPoint()) - axis, color);
}
extern "C" __global__ void __miss__sky() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

DEVICE FairPoint find(float3 from, float3 direction, float time) {
    unsigned p[9];
    optixTrace(params.fair, from, direction, 0.0f, 1e16f, time, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, p[0], p[1], p[2], p[3], p[4], p[5], p[6],
               p[7], p[8]);
    return {__uint_as_float(p[0]),
            vec(__uint_as_float(p[1]), __uint_as_float(p[2]), __uint_as_float(p[3])),
            vec(__uint_as_float(p[4]), __uint_as_float(p[5]), __uint_as_float(p[6])),
            __uint_as_float(p[7]), __uint_as_float(p[8])};
}
DEVICE bool sunReaches(float3 from, float time) {
    unsigned open = 0, unused = 0;
    optixTrace(params.fair, from, params.sun, 1e-3f, 1e16f, time, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, open, unused, unused, unused, unused, unused, unused, unused, unused);
    return open != 0;
}
DEVICE float3 eveningSky(float3 direction) {
    const float height = sqrtf(fmaxf(direction.y, 0.0f));
    return lerp(vec(0.85f, 0.6f, 0.45f), vec(0.22f, 0.33f, 0.6f), height);
}

DEVICE float3 followPath(float3 origin, float3 direction, float time, unsigned& random) {
    float3 sum = vec(0.0f), share = vec(1.0f);
    for (unsigned bounce = 0; bounce <= params.bounces; ++bounce) {
        const FairPoint p = find(origin, direction, time);
        if (p.distance < 0.0f)
            return sum + share * eveningSky(direction);
        sum += share * p.color * p.glow;
        origin = origin + direction * p.distance + p.normal * 2e-3f;
        const float u = nextFloat(random), v = nextFloat(random);
        if (nextFloat(random) < p.mirror) {
            direction = reflect(direction, p.normal);
            share = share * lerp(vec(1.0f), p.color, 0.7f);
            continue;
        }
        share = share * p.color;
        const float cosine = dot(p.normal, params.sun);
        if (cosine > 0.0f && sunReaches(origin, time))
            sum += share * vec(1.9f, 1.5f, 1.05f) * cosine;
        direction = cosineDirection(p.normal, u, v);
    }
    return sum;
}

extern "C" __global__ void __raygen__fair() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        const float time = (i + nextFloat(random)) / params.samples;
        sum += followPath(params.camera.eye, cameraDirection(params.camera, x, y), time, random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
