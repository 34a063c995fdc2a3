// SPDX-License-Identifier: Apache-2.0
// Molecules of spheres and of sticks between them, with contours: rays around the pixel compare
// depths. The closest-hit program only returns what it hit; a callable of the instance colours it.
// Payload: distance, instance, primitive, normal, record's gloss and colour.
#include "molecules.h"
#include "tools.h"

extern "C" {
__constant__ MoleculeParams params;
}

struct Atom {
    float distance; // negative: none
    unsigned instance, primitive;
    float3 normal, color;
    float gloss;
};

DEVICE void answer(float3 normal) {
    const auto* r = reinterpret_cast<const MoleculeRecord*>(optixGetSbtDataPointer());
    normal = normalize(optixTransformNormalFromObjectToWorldSpace(normal));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(optixGetInstanceId());
    optixSetPayload_2(optixGetPrimitiveIndex());
    optixSetPayload_3(__float_as_uint(normal.x));
    optixSetPayload_4(__float_as_uint(normal.y));
    optixSetPayload_5(__float_as_uint(normal.z));
    optixSetPayload_6(__float_as_uint(r->color.x));
    optixSetPayload_7(__float_as_uint(r->color.y));
    optixSetPayload_8(__float_as_uint(r->color.z));
    optixSetPayload_9(__float_as_uint(r->gloss));
}
extern "C" __global__ void __closesthit__atom() {
    float4 sphere[1];
    optixGetSphereData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                       optixGetSbtGASIndex(), 0.0f, sphere);
    const float3 point = optixTransformPointFromWorldToObjectSpace(rayPoint());
    answer(point - vec(sphere[0].x, sphere[0].y, sphere[0].z));
}
extern "C" __global__ void __closesthit__stick() {
    float4 ends[2];
    optixGetLinearCurveVertexData(optixGetGASTraversableHandle(), optixGetPrimitiveIndex(),
                                  optixGetSbtGASIndex(), 0.0f, ends);
    const float u = optixGetCurveParameter();
    const float3 point = optixTransformPointFromWorldToObjectSpace(rayPoint());
    const float3 a = vec(ends[0].x, ends[0].y, ends[0].z), b = vec(ends[1].x, ends[1].y, ends[1].z);
    answer(point - lerp(a, b, u));
}
extern "C" __global__ void __miss__none() {
    optixSetPayload_0(__float_as_uint(-1.0f));
    optixSetPayload_1(~0u);
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

DEVICE Atom find(float3 direction) {
    unsigned p[10];
    optixTrace(params.cell, params.camera.eye, direction, 0.0f, 1e16f, 0.0f,
               OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, p[0], p[1], p[2],
               p[3], p[4], p[5], p[6], p[7], p[8], p[9]);
    return {__uint_as_float(p[0]),
            p[1],
            p[2],
            vec(__uint_as_float(p[3]), __uint_as_float(p[4]), __uint_as_float(p[5])),
            vec(__uint_as_float(p[6]), __uint_as_float(p[7]), __uint_as_float(p[8])),
            __uint_as_float(p[9])};
}
DEVICE bool isOpen(float3 from, float3 direction, float reach) {
    unsigned open = 0, unused = 0;
    optixTrace(params.cell, from, direction, 1e-3f, reach, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, open, unused, unused, unused, unused, unused, unused, unused, unused,
               unused);
    return open != 0;
}

extern "C" __device__ float3 __direct_callable__element(const Atom& atom) {
    return atom.color;
}
extern "C" __device__ float3 __direct_callable__chain(const Atom& atom) {
    const float2 hue = circlePoint((hashPcg(atom.instance) >> 8) * 0x1p-24f);
    return lerp(vec(0.55f + 0.35f * hue.x, 0.55f + 0.35f * hue.y, 0.55f - 0.3f * hue.x), atom.color,
                0.15f);
}
// Residues of 60 primitives have a charge.
extern "C" __device__ float3 __direct_callable__charge(const Atom& atom) {
    const float charge =
        (hashPcg(atom.instance * 4096 + atom.primitive / 60) >> 8) * 0x1p-23f - 1.0f;
    return lerp(vec(0.9f), charge < 0.0f ? vec(0.85f, 0.15f, 0.15f) : vec(0.15f, 0.25f, 0.85f),
                fabsf(charge));
}

DEVICE float3 shade(const Atom& atom, float3 direction, unsigned& random) {
    const float3 color = optixDirectCall<float3, const Atom&>(atom.instance % kColorings, atom);
    const float3 point = params.camera.eye + direction * atom.distance + atom.normal * 2e-3f;
    float open = 0.0f;
    for (unsigned i = 0; i < params.openRays; ++i) {
        const float u = nextFloat(random), v = nextFloat(random);
        open += isOpen(point, cosineDirection(atom.normal, u, v), params.reach);
    }
    float3 light = vec(0.65f, 0.68f, 0.72f) * (open / params.openRays);
    const float cosine = dot(atom.normal, params.sun);
    float shine = 0.0f;
    if (cosine > 0.0f && isOpen(point, params.sun, 1e16f)) {
        light += vec(0.75f, 0.72f, 0.65f) * cosine;
        shine =
            atom.gloss * powf(fmaxf(dot(reflect(direction, atom.normal), params.sun), 0.0f), 40.0f);
    }
    return color * light + vec(shine);
}

// How much of the surroundings of a pixel lies far behind its atom, or in another molecule.
DEVICE float contourAt(const Atom& atom, float x, float y) {
    const uint3 size = optixGetLaunchDimensions();
    float sum = 0.0f;
    for (unsigned i = 0; i < params.contourRays; ++i) {
        const float2 c = circlePoint(static_cast<float>(i) / params.contourRays);
        const Atom other =
            find(cameraDirection(params.camera, (x + params.contourWidth * c.x) / size.x,
                                 (y + params.contourWidth * c.y) / size.y));
        const float step = other.distance < 0.0f ? 10.0f : other.distance - atom.distance;
        sum += clamp01(0.4f * step - 0.3f) +
               (other.instance != atom.instance && step > 0.0f ? 0.3f : 0.0f);
    }
    return sum / params.contourRays;
}

extern "C" __global__ void __raygen__cell() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    const float x = index.x + 0.5f, y = index.y + 0.5f;
    const float3 direction = cameraDirection(params.camera, x / size.x, y / size.y);
    const float3 paper = lerp(vec(0.97f, 0.96f, 0.93f), vec(0.8f, 0.85f, 0.9f), y / size.y);
    const Atom atom = find(direction);
    float3 color = paper;
    if (atom.distance >= 0.0f) {
        const float fog = clamp01((atom.distance - params.fogStart) / (2.0f * params.fogStart));
        const float ink = clamp01(2.0f * contourAt(atom, x, y)) * (1.0f - fog);
        color = lerp(shade(atom, direction, random), paper, fog) * (1.0f - 0.85f * ink);
    }
    params.image[pixel] = withWeight(color, 1.0f);
}
