// SPDX-License-Identifier: Apache-2.0
// Spheres as custom primitives: an intersection program computes where a ray meets a sphere,
// closest-hit programs shade by material and trace further rays, and an any-hit program cuts holes.
// Payload values 0 to 2 carry the colour back, value 3 carries the number of the bounce forward.
#include <optix.h>

#include "params.h"

extern "C" {
__constant__ Params params;
}

#define DEVICE static __forceinline__ __device__

DEVICE void setColor(float3 color) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
}

DEVICE float3 skyColor(float3 direction) {
    float height = 0.5f + 0.5f * direction.y;
    return lerp(vec(0.95f, 0.93f, 0.9f), vec(0.25f, 0.45f, 0.85f), height);
}

DEVICE float3 traceColor(float3 origin, float3 direction, unsigned bounce) {
    unsigned red = 0, green = 0, blue = 0;
    if (bounce >= kMaxTraceDepth - 1) // the last level is kept for shadow rays
        return skyColor(direction);
    optixTrace(params.scene, origin, direction, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_NONE, kRadianceRay, kRayTypeCount, kRadianceRay, red, green, blue,
               bounce);
    return vec(__uint_as_float(red), __uint_as_float(green), __uint_as_float(blue));
}

// Whether the light is visible from `origin`: only the miss program sets the result.
DEVICE bool seesLight(float3 origin) {
    unsigned visible = 0;
    optixTrace(params.scene, origin, params.lightDirection, 1e-3f, 1e16f, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               kShadowRay, kRayTypeCount, kShadowRay, visible);
    return visible != 0;
}

DEVICE float3 hitPoint() {
    return optixGetWorldRayOrigin() + optixGetWorldRayDirection() * optixGetRayTmax();
}

// Unit normal at a point of the sphere, pointing outwards.
DEVICE float3 normalAt(const Sphere& sphere, float3 point) {
    return normalize(point - sphere.center);
}

DEVICE float3 litMatte(float3 color, float3 point, float3 normal) {
    float3 ambient = skyColor(normal) * 0.35f;
    float cosine = dot(normal, params.lightDirection);
    float3 light = vec(0.0f);
    if (cosine > 0.0f && seesLight(point + normal * 1e-3f))
        light = vec(1.0f, 0.95f, 0.85f) * (0.9f * cosine);
    return color * (ambient + light);
}

extern "C" __global__ void __raygen__camera() {
    uint3 index = optixGetLaunchIndex();
    uint3 size = optixGetLaunchDimensions();
    unsigned axis = params.samplesPerAxis;
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < axis * axis; ++i) {
        float x = (index.x + (i % axis + 0.5f) / axis) / size.x;
        float y = (index.y + (i / axis + 0.5f) / axis) / size.y;
        sum += traceColor(params.camera.eye, cameraDirection(params.camera, x, y), 0);
    }
    sum = sum / float(axis * axis);
    float4 pixel;
    pixel.x = sum.x;
    pixel.y = sum.y;
    pixel.z = sum.z;
    pixel.w = 1.0f;
    params.image[index.y * size.x + index.x] = pixel;
}

extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()));
}

extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(1);
}

// The half chord from the point nearest to the centre: exact enough for a sphere as large as the
// ground, where the textbook discriminant cancels.
extern "C" __global__ void __intersection__sphere() {
    const Sphere& sphere = params.spheres[optixGetPrimitiveIndex()];
    float3 direction = optixGetObjectRayDirection();
    float scale = 1.0f / length(direction);
    direction = direction * scale;
    float3 toOrigin = optixGetObjectRayOrigin() - sphere.center;
    float middle = -dot(toOrigin, direction);
    float3 nearest = toOrigin + direction * middle;
    float halfChordSquared = sphere.radius * sphere.radius - dot(nearest, nearest);
    if (halfChordSquared < 0.0f)
        return;
    float halfChord = sqrtf(halfChordSquared);
    // Hit kind 0: the ray enters the sphere; 1: it leaves.
    if (!optixReportIntersection((middle - halfChord) * scale, 0))
        optixReportIntersection((middle + halfChord) * scale, 1);
}

// Holes in a pattern of latitude and longitude: a ray continues through them.
extern "C" __global__ void __anyhit__cutout() {
    const Sphere& sphere = params.spheres[optixGetPrimitiveIndex()];
    float3 normal = normalAt(sphere, hitPoint());
    int cells =
        int(floorf(normal.x * 4.0f)) + int(floorf(normal.y * 4.0f)) + int(floorf(normal.z * 4.0f));
    if (cells & 1)
        optixIgnoreIntersection();
}

extern "C" __global__ void __closesthit__matte() {
    const Sphere& sphere = params.spheres[optixGetPrimitiveIndex()];
    float3 point = hitPoint();
    float3 normal = normalAt(sphere, point);
    if (dot(normal, optixGetWorldRayDirection()) > 0.0f) // seen from inside, through a hole
        normal = -normal;
    setColor(litMatte(sphere.color, point, normal));
}

extern "C" __global__ void __closesthit__checkered() {
    const Sphere& sphere = params.spheres[optixGetPrimitiveIndex()];
    float3 point = hitPoint();
    int cells = int(floorf(point.x)) + int(floorf(point.z));
    float3 color = (cells & 1) ? sphere.color : sphere.color * 0.35f;
    float distance = optixGetRayTmax();
    float fog = distance / (distance + 60.0f);
    float3 lit = litMatte(color, point, normalAt(sphere, point));
    setColor(lerp(lit, skyColor(optixGetWorldRayDirection()), fog * fog));
}

extern "C" __global__ void __closesthit__metal() {
    const Sphere& sphere = params.spheres[optixGetPrimitiveIndex()];
    float3 point = hitPoint();
    float3 normal = normalAt(sphere, point);
    float3 direction = reflect(optixGetWorldRayDirection(), normal);
    setColor(sphere.color * traceColor(point + normal * 1e-3f, direction, optixGetPayload_3() + 1));
}

extern "C" __global__ void __closesthit__glass() {
    const Sphere& sphere = params.spheres[optixGetPrimitiveIndex()];
    float3 point = hitPoint();
    float3 incoming = optixGetWorldRayDirection();
    bool leaving = optixGetHitKind() == 1;
    float3 normal = normalAt(sphere, point) * (leaving ? -1.0f : 1.0f);
    float ratio = leaving ? sphere.index : 1.0f / sphere.index;
    float cosine = -dot(incoming, normal);
    float sineSquared = ratio * ratio * (1.0f - cosine * cosine);

    // Schlick's approximation of the share of light that is reflected.
    float base = (1.0f - sphere.index) / (1.0f + sphere.index);
    float edge = 1.0f - cosine;
    float reflected = base * base + (1.0f - base * base) * edge * edge * edge * edge * edge;
    unsigned bounce = optixGetPayload_3() + 1;
    float3 color = vec(0.0f);
    if (sineSquared >= 1.0f)
        reflected = 1.0f; // total reflection
    else
        color = traceColor(point - normal * 1e-3f,
                           incoming * ratio + normal * (ratio * cosine - sqrtf(1.0f - sineSquared)),
                           bounce) *
                (1.0f - reflected);
    // Inside, weak reflections are dropped: each would double the number of rays.
    if (!leaving || reflected == 1.0f)
        color += traceColor(point + normal * 1e-3f, reflect(incoming, normal), bounce) * reflected;
    setColor(color * sphere.color);
}
