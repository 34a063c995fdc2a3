// SPDX-License-Identifier: Apache-2.0
// Assemblies of balls, discs, boxes and rods, whose intersection programs are a few lines each. Ray
// generation shades. Attributes: the normal. Payload: distance, normal, colour.
#include "assemblies.h"
#include "tools.h"

extern "C" {
__constant__ AssemblyParams params;
}

struct PartHit {
    float distance; // negative: none
    float3 normal, color;
};

DEVICE const AssemblyPart& partOfRay() {
    const auto* r = reinterpret_cast<const AssemblyRecord*>(optixGetSbtDataPointer());
    return r->parts[optixGetPrimitiveIndex()];
}
DEVICE bool isOnRay(float t) {
    return t > optixGetRayTmin() && t < optixGetRayTmax();
}
DEVICE void report(float t, float3 normal) {
    optixReportIntersection(t, 0, __float_as_uint(normal.x), __float_as_uint(normal.y),
                            __float_as_uint(normal.z));
}

extern "C" __global__ void __intersection__ball() {
    const AssemblyPart& part = partOfRay();
    const float3 d = optixGetObjectRayDirection(), from = optixGetObjectRayOrigin() - part.at;
    const float a = dot(d, d), b = dot(from, d) / a;
    const float3 nearest = from - d * b;
    const float squared = part.radius * part.radius - dot(nearest, nearest);
    if (squared < 0.0f)
        return;
    const float half = sqrtf(squared / a), t = isOnRay(-b - half) ? -b - half : half - b;
    if (isOnRay(t))
        report(t, from + d * t);
}
extern "C" __global__ void __intersection__disc() {
    const AssemblyPart& part = partOfRay();
    const float3 d = optixGetObjectRayDirection(), from = optixGetObjectRayOrigin() - part.at;
    const float t = -dot(from, part.extent) / dot(d, part.extent);
    const float3 point = from + d * t;
    if (isOnRay(t) && dot(point, point) < part.radius * part.radius)
        report(t, part.extent);
}
extern "C" __global__ void __intersection__box() {
    const AssemblyPart& part = partOfRay();
    const float3 d = optixGetObjectRayDirection(), from = optixGetObjectRayOrigin() - part.at;
    const float3 inverse = vec(1.0f / d.x, 1.0f / d.y, 1.0f / d.z);
    const float3 middle = -from * inverse;
    const float3 half = vec(fabsf(inverse.x), fabsf(inverse.y), fabsf(inverse.z)) * part.extent;
    const float3 low = middle - half, high = middle + half;
    const float enter = fmaxf(low.x, fmaxf(low.y, low.z));
    const float leave = fminf(high.x, fminf(high.y, high.z));
    if (enter > leave)
        return;
    const float t = isOnRay(enter) ? enter : leave;
    const float3 sides = t == enter ? low : high;
    if (isOnRay(t))
        report(t, vec(sides.x == t, sides.y == t, sides.z == t));
}
// A tube without ends.
extern "C" __global__ void __intersection__rod() {
    const AssemblyPart& part = partOfRay();
    const float3 d = optixGetObjectRayDirection(), from = optixGetObjectRayOrigin() - part.at;
    const float along = dot(d, part.extent), start = dot(from, part.extent);
    const float3 across = d - part.extent * along, off = from - part.extent * start;
    const float a = dot(across, across), b = dot(off, across);
    const float squared = b * b - a * (dot(off, off) - part.radius * part.radius);
    if (squared < 0.0f || a == 0.0f)
        return;
    const float root = sqrtf(squared);
    for (int side = -1; side <= 1; side += 2) {
        const float t = (side * root - b) / a;
        if (isOnRay(t) && fabsf(start + along * t) < part.half) {
            report(t, off + across * t);
            return;
        }
    }
}

extern "C" __global__ void __closesthit__part() {
    const float3 local =
        vec(__uint_as_float(optixGetAttribute_0()), __uint_as_float(optixGetAttribute_1()),
            __uint_as_float(optixGetAttribute_2()));
    const float3 normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(local)));
    const float3 color = partOfRay().color;
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(__float_as_uint(normal.x));
    optixSetPayload_2(__float_as_uint(normal.y));
    optixSetPayload_3(__float_as_uint(normal.z));
    optixSetPayload_4(__float_as_uint(color.x));
    optixSetPayload_5(__float_as_uint(color.y));
    optixSetPayload_6(__float_as_uint(color.z));
}
extern "C" __global__ void __miss__sky() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

DEVICE PartHit find(float3 from, float3 direction) {
    unsigned p[7];
    optixTrace(params.yard, from, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, p[0], p[1], p[2], p[3], p[4], p[5], p[6]);
    return {__uint_as_float(p[0]),
            vec(__uint_as_float(p[1]), __uint_as_float(p[2]), __uint_as_float(p[3])),
            vec(__uint_as_float(p[4]), __uint_as_float(p[5]), __uint_as_float(p[6]))};
}
DEVICE bool isOpen(float3 from, float3 direction, float reach) {
    unsigned open = 0, unused = 0;
    optixTrace(params.yard, from, direction, 1e-3f, reach, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, open, unused, unused, unused, unused, unused, unused);
    return open != 0;
}
DEVICE float3 shade(const PartHit& hit, float3 direction, unsigned& random) {
    const float3 point = params.camera.eye + direction * hit.distance + hit.normal * 2e-3f;
    unsigned open = 0;
    for (unsigned i = 0; i < params.openRays; ++i) {
        const float u = nextFloat(random), v = nextFloat(random);
        open += isOpen(point, cosineDirection(hit.normal, u, v), params.reach);
    }
    float3 light = blueSky(hit.normal) * (0.6f * open / params.openRays);
    float shine = 0.0f;
    const float cosine = dot(hit.normal, params.sun);
    if (cosine > 0.0f && isOpen(point, params.sun, 1e16f)) {
        light += vec(1.5f, 1.35f, 1.1f) * cosine;
        shine = powf(fmaxf(dot(reflect(direction, hit.normal), params.sun), 0.0f), 50.0f);
    }
    return hit.color * light + vec(0.25f * shine);
}

extern "C" __global__ void __raygen__yard() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        const float3 direction = cameraDirection(params.camera, x, y);
        const PartHit hit = find(params.camera.eye, direction);
        sum += hit.distance < 0.0f ? blueSky(direction) : shade(hit, direction, random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
