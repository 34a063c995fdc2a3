// SPDX-License-Identifier: Apache-2.0
// Hair of round curves. OptiX intersects them; a closest-hit program reads the control points of
// the hit segment and computes the surface's normal from them.
#include <optix.h>

#include "params.h"
#include "sampling.h"

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
    float height = clamp01(0.5f + 0.5f * direction.y);
    return lerp(vec(0.93f, 0.89f, 0.84f), vec(0.45f, 0.58f, 0.78f), height);
}

DEVICE bool seesLight(float3 origin) {
    unsigned visible = 0;
    optixTrace(params.scene, origin, params.lightDirection, 1e-3f, 1e16f, 0.0f,
               OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_ANYHIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, kShadowRay, visible);
    return visible != 0;
}

extern "C" __global__ void __raygen__camera() {
    uint3 index = optixGetLaunchIndex();
    uint3 size = optixGetLaunchDimensions();
    unsigned axis = params.samplesPerAxis;
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < axis * axis; ++i) {
        float x = (index.x + (i % axis + 0.5f) / axis) / size.x;
        float y = (index.y + (i / axis + 0.5f) / axis) / size.y;
        unsigned red = 0, green = 0, blue = 0;
        optixTrace(params.scene, params.camera.eye, cameraDirection(params.camera, x, y), 1e-3f,
                   1e16f, 0.0f, OptixVisibilityMask(255), OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1,
                   kRadianceRay, red, green, blue);
        sum += vec(__uint_as_float(red), __uint_as_float(green), __uint_as_float(blue));
    }
    sum = sum / float(axis * axis);
    float4 pixel;
    pixel.x = sum.x;
    pixel.y = sum.y;
    pixel.z = sum.z;
    pixel.w = 1.0f;
    params.image[index.y * size.x + index.x] = pixel;
}

// Sky, and a floor at y = 0 that fades into it.
extern "C" __global__ void __miss__backdrop() {
    float3 origin = optixGetWorldRayOrigin(), direction = optixGetWorldRayDirection();
    float3 sky = skyColor(direction);
    if (direction.y >= -1e-4f)
        return setColor(sky);
    float distance = -origin.y / direction.y;
    float light = seesLight(origin + direction * distance) ? 1.0f : 0.45f;
    float fog = distance / (distance + 40.0f);
    setColor(lerp(vec(0.78f, 0.74f, 0.7f) * light, sky, fog * fog));
}

extern "C" __global__ void __miss__shadow() {
    optixSetPayload_0(1);
}

DEVICE float4 scaled(float4 a, float s) {
    return make_float4(a.x * s, a.y * s, a.z * s, a.w * s);
}
DEVICE float4 sum(float4 a, float4 b) {
    return make_float4(a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w);
}
DEVICE float4 mix(float4 a, float4 b, float4 c, float4 d, const float* weights) {
    return sum(sum(scaled(a, weights[0]), scaled(b, weights[1])),
               sum(scaled(c, weights[2]), scaled(d, weights[3])));
}

// A segment as a polynomial of u: the sum of coefficient[k] u^k, in x, y, z and the radius.
struct Segment {
    float4 coefficient[4];
};

// The polynomial of the hit segment.
DEVICE Segment hitSegment() {
    const OptixTraversableHandle geometry = optixGetGASTraversableHandle();
    const unsigned primitive = optixGetPrimitiveIndex(), input = optixGetSbtGASIndex();
    // Rows: powers of u; columns: control points.
    const float linear[4][4] = {{1, 0, 0, 0}, {-1, 1, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}};
    const float quadratic[4][4] = {
        {0.5f, 0.5f, 0, 0}, {-1, 1, 0, 0}, {0.5f, -1, 0.5f, 0}, {0, 0, 0, 0}};
    const float cubic[4][4] = {{1 / 6.0f, 4 / 6.0f, 1 / 6.0f, 0},
                               {-0.5f, 0, 0.5f, 0},
                               {0.5f, -1, 0.5f, 0},
                               {-1 / 6.0f, 0.5f, -0.5f, 1 / 6.0f}};
    const float catmullRom[4][4] = {
        {0, 1, 0, 0}, {-0.5f, 0, 0.5f, 0}, {1, -2.5f, 2, -0.5f}, {-0.5f, 1.5f, -1.5f, 0.5f}};
    float4 p[4];
    for (int i = 0; i < 4; ++i)
        p[i] = make_float4(0, 0, 0, 0);
    const float(*rows)[4];
    switch (optixGetPrimitiveType()) {
    case OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR:
        optixGetLinearCurveVertexData(geometry, primitive, input, 0.0f, p);
        rows = linear;
        break;
    case OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE:
        optixGetQuadraticBSplineVertexData(geometry, primitive, input, 0.0f, p);
        rows = quadratic;
        break;
    case OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE:
        optixGetCubicBSplineVertexData(geometry, primitive, input, 0.0f, p);
        rows = cubic;
        break;
    default:
        optixGetCatmullRomVertexData(geometry, primitive, input, 0.0f, p);
        rows = catmullRom;
        break;
    }
    Segment segment;
    for (int k = 0; k < 4; ++k)
        segment.coefficient[k] = mix(p[0], p[1], p[2], p[3], rows[k]);
    return segment;
}

// The surface is a disc of radius r(u), perpendicular to the curve, swept along it.
DEVICE float3 normalAt(float3 point, float u, float3& tangent) {
    const Segment s = hitSegment();
    const float4* c = s.coefficient;
    const float4 at =
        sum(sum(c[0], scaled(c[1], u)), sum(scaled(c[2], u * u), scaled(c[3], u * u * u)));
    const float4 first = sum(c[1], sum(scaled(c[2], 2 * u), scaled(c[3], 3 * u * u)));
    const float4 second = sum(scaled(c[2], 2), scaled(c[3], 6 * u));
    tangent = vec(first.x, first.y, first.z);
    const float3 outward = point - vec(at.x, at.y, at.z);
    // The joints of linear segments are spheres.
    const bool isJoint = u == 0.0f || u == 1.0f;
    const float pace = dot(tangent, tangent) - dot(outward, vec(second.x, second.y, second.z));
    const float3 normal = isJoint ? outward : outward * pace - tangent * (first.w * at.w);
    tangent = normalize(tangent);
    return normalize(normal);
}

extern "C" __global__ void __closesthit__hair() {
    const HairData& hair = *reinterpret_cast<const HairData*>(optixGetSbtDataPointer());
    const float3 direction = optixGetWorldRayDirection();
    const float3 point = optixGetWorldRayOrigin() + direction * optixGetRayTmax();
    const float u = optixGetCurveParameter();
    // Instances are only translated, so directions are equal in object and world space.
    float3 tangent;
    const float3 normal = normalAt(optixTransformPointFromWorldToObjectSpace(point), u, tangent);

    const unsigned strand = optixGetPrimitiveIndex() / hair.segmentsPerStrand;
    const unsigned segment = optixGetPrimitiveIndex() % hair.segmentsPerStrand;
    const float along = (segment + u) / hair.segmentsPerStrand; // 0: root, 1: tip
    const float shade = 0.75f + 0.5f * (hashPcg(strand) >> 8) * 0x1p-24f;
    const float3 color = hair.color * (shade * (0.6f + 0.6f * along));

    // Little light of the sky reaches the roots.
    float3 light = skyColor(normal) * (0.08f + 0.5f * along * along);
    const float cosine = dot(normal, params.lightDirection);
    float3 gloss = vec(0.0f);
    if (cosine > 0.0f && seesLight(point + normal * 2e-3f)) {
        light += vec(1.0f, 0.93f, 0.82f) * cosine;
        // A cylinder's highlight lies where light and eye make the same angle with its axis.
        const float l = dot(tangent, params.lightDirection), e = dot(tangent, direction);
        float shine = clamp01(sqrtf(clamp01(1 - l * l)) * sqrtf(clamp01(1 - e * e)) + l * e);
        shine *= shine;
        shine *= shine;
        shine *= shine;
        gloss = vec(0.3f, 0.28f, 0.25f) * (shine * shine * cosine);
    }
    setColor(color * light + gloss);
}
