// SPDX-License-Identifier: Apache-2.0
// Materials composed of callables: one closest-hit program calls a direct callable for the colour
// of the surface and a continuation callable for the light that leaves it. Only continuation
// callables may trace rays. Payload values 0 to 2 carry a colour back, value 3 the number of the
// bounce forward.
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
    return lerp(vec(0.96f, 0.9f, 0.84f), vec(0.2f, 0.36f, 0.7f), height);
}

DEVICE float3 traceColor(float3 origin, float3 direction, unsigned bounce) {
    if (bounce >= kMaxTraceDepth - 1) // the last level is kept for shadow rays
        return skyColor(direction);
    unsigned red = 0, green = 0, blue = 0;
    optixTrace(params.scene, origin, direction, 1e-3f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, kRadianceRay, red, green, blue, bounce);
    return vec(__uint_as_float(red), __uint_as_float(green), __uint_as_float(blue));
}

DEVICE float callableScale() {
    return reinterpret_cast<const CallableData*>(optixGetSbtDataPointer())->scale;
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

extern "C" __global__ void __intersection__shape() {
    const Shape& shape = params.shapes[optixGetPrimitiveIndex()];
    float3 origin = optixGetObjectRayOrigin(), direction = optixGetObjectRayDirection();
    if (shape.radius == 0.0f) {
        float t = -origin.y / direction.y;
        float3 p = origin + direction * t;
        if (fabsf(p.x) < kFloorSize && fabsf(p.z) < kFloorSize)
            optixReportIntersection(t, 0);
        return;
    }
    float3 toOrigin = origin - shape.center;
    float middle = -dot(toOrigin, direction);
    float3 nearest = toOrigin + direction * middle;
    float square = shape.radius * shape.radius - dot(nearest, nearest);
    if (square < 0.0f)
        return;
    float half = sqrtf(square);
    // Hit kind 0: the ray enters; 1: it leaves.
    if (!optixReportIntersection(middle - half, 0))
        optixReportIntersection(middle + half, 1);
}

extern "C" __global__ void __closesthit__shape() {
    const Shape& shape = params.shapes[optixGetPrimitiveIndex()];
    Point point;
    point.incoming = optixGetWorldRayDirection();
    point.position = optixGetWorldRayOrigin() + point.incoming * optixGetRayTmax();
    point.local = point.position - shape.center;
    point.normal = vec(0.0f, 1.0f, 0.0f);
    if (shape.radius > 0.0f)
        point.normal = point.local = point.local / shape.radius;
    point.isInside = optixGetHitKind();
    point.bounce = optixGetPayload_3();
    point.colors[0] = shape.colors[0];
    point.colors[1] = shape.colors[1];
    float3 color = optixDirectCall<float3, Point>(shape.pattern, point);
    setColor(optixContinuationCall<float3, Point, float3>(shape.material, point, color));
}

// ---- Patterns: direct callables -----------------------------------------------------------------

extern "C" __device__ float3 __direct_callable__solid(Point point) {
    return point.colors[0];
}

extern "C" __device__ float3 __direct_callable__checks(Point point) {
    float3 p = point.local * callableScale() + vec(1e-3f);
    int cells = int(floorf(p.x)) + int(floorf(p.y)) + int(floorf(p.z));
    return point.colors[cells & 1];
}

extern "C" __device__ float3 __direct_callable__rings(Point point) {
    float height = point.local.y * callableScale();
    float part = height - floorf(height);
    float blend = clamp01(8.0f * (fabsf(part - 0.5f) - 0.22f));
    return lerp(point.colors[0], point.colors[1], blend);
}

DEVICE float lattice(int x, int y, int z) {
    unsigned n = unsigned(x) * 374761393u + unsigned(y) * 668265263u + unsigned(z) * 2147483647u;
    n = (n ^ (n >> 13)) * 1274126177u;
    return float((n ^ (n >> 16)) & 0xffff) * (1.0f / 65535.0f);
}

DEVICE float noise(float3 p) {
    float fx = floorf(p.x), fy = floorf(p.y), fz = floorf(p.z);
    int x = int(fx), y = int(fy), z = int(fz);
    float u = p.x - fx, v = p.y - fy, w = p.z - fz, sum = 0.0f;
    u = u * u * (3.0f - 2.0f * u);
    v = v * v * (3.0f - 2.0f * v);
    w = w * w * (3.0f - 2.0f * w);
    for (int corner = 0; corner < 8; ++corner) {
        int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
        sum += lattice(x + i, y + j, z + k) * (i ? u : 1.0f - u) * (j ? v : 1.0f - v) *
               (k ? w : 1.0f - w);
    }
    return sum;
}

extern "C" __device__ float3 __direct_callable__marble(Point point) {
    float3 p = point.local * callableScale();
    float turbulence = 0.0f, weight = 1.0f;
    for (int octave = 0; octave < 5; ++octave) {
        turbulence += weight * fabsf(noise(p * float(1 << octave)) - 0.5f);
        weight *= 0.5f;
    }
    float wave = p.x + p.y * 0.6f + 3.0f * turbulence;
    float vein = fabsf(2.0f * (wave - floorf(wave)) - 1.0f);
    return lerp(point.colors[0], point.colors[1], vein * vein * vein * vein);
}

// ---- Materials: continuation callables
// ------------------------------------------------------------

DEVICE float3 litMatte(const Point& point, float3 color) {
    float3 normal = point.isInside ? -point.normal : point.normal;
    float3 light = skyColor(normal) * 0.4f;
    float cosine = dot(normal, params.lightDirection);
    if (cosine > 0.0f) {
        unsigned visible = 0, unused = 0;
        optixTrace(params.scene, point.position + normal * 1e-3f, params.lightDirection, 1e-3f,
                   1e16f, 0.0f, OptixVisibilityMask(255),
                   OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                       OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
                   0, 0, kShadowRay, visible, unused, unused, unused);
        if (visible)
            light += vec(1.0f, 0.94f, 0.84f) * (0.95f * cosine);
    }
    return color * light;
}

// Schlick's approximation of the share of light that a surface reflects.
DEVICE float reflectance(float cosine, float index) {
    float base = (1.0f - index) / (1.0f + index);
    float edge = 1.0f - clamp01(cosine);
    return base * base + (1.0f - base * base) * edge * edge * edge * edge * edge;
}

DEVICE float3 reflection(const Point& point) {
    return traceColor(point.position + point.normal * 1e-3f, reflect(point.incoming, point.normal),
                      point.bounce + 1);
}

extern "C" __device__ float3 __continuation_callable__matte(Point point, float3 color) {
    return litMatte(point, color);
}

extern "C" __device__ float3 __continuation_callable__polished(Point point, float3 color) {
    float share = reflectance(-dot(point.incoming, point.normal), callableScale());
    return litMatte(point, color) * (1.0f - share) + reflection(point) * share;
}

extern "C" __device__ float3 __continuation_callable__mirror(Point point, float3 color) {
    return reflection(point) * color;
}

extern "C" __device__ float3 __continuation_callable__glass(Point point, float3 color) {
    float index = callableScale();
    float3 normal = point.isInside ? -point.normal : point.normal;
    float ratio = point.isInside ? index : 1.0f / index;
    float cosine = -dot(point.incoming, normal);
    float square = ratio * ratio * (1.0f - cosine * cosine);
    float share = square >= 1.0f ? 1.0f : reflectance(cosine, index);
    float3 sum = vec(0.0f);
    if (share < 1.0f)
        sum = traceColor(point.position - normal * 1e-3f,
                         point.incoming * ratio + normal * (ratio * cosine - sqrtf(1.0f - square)),
                         point.bounce + 1) *
              (1.0f - share);
    // Inside, weak reflections are dropped: each would double the number of rays.
    if (!point.isInside || share == 1.0f)
        sum += traceColor(point.position + normal * 1e-3f, reflect(point.incoming, normal),
                          point.bounce + 1) *
               share;
    return sum * color;
}
