// SPDX-License-Identifier: Apache-2.0
// A height field: the intersection program descends a pyramid of height ranges from front to back
// and intersects the triangles of cells. Closest-hit programs shade land, and water, which traces a
// reflection. Payload: colour, depth, random state.
#include "height_field.h"
#include "tools.h"

extern "C" {
__constant__ HeightParams params;
}

DEVICE const HeightRecord& land() {
    return *reinterpret_cast<const HeightRecord*>(optixGetSbtDataPointer());
}
DEVICE float3 vertexAt(const HeightRecord& r, int x, int z) {
    return vec(x, r.heights[z * r.across + x], z);
}

struct FieldRay {
    float3 origin, direction, inverse;
    float tmin, tmax;
};

// The part of a ray over a box; false if it misses.
DEVICE bool clip(const FieldRay& ray, float3 low, float3 high) {
    const float3 a = (low - ray.origin) * ray.inverse, b = (high - ray.origin) * ray.inverse;
    const float enter =
        fmaxf(fmaxf(fminf(a.x, b.x), fminf(a.y, b.y)), fmaxf(fminf(a.z, b.z), ray.tmin));
    const float leave =
        fminf(fminf(fmaxf(a.x, b.x), fmaxf(a.y, b.y)), fminf(fmaxf(a.z, b.z), ray.tmax));
    return enter <= leave * 1.000001f;
}
DEVICE bool meetTriangle(const FieldRay& ray, float3 a, float3 b, float3 c, float& t) {
    const float3 u = b - a, v = c - a, p = cross(ray.direction, v);
    const float determinant = dot(u, p);
    if (fabsf(determinant) < 1e-20f)
        return false;
    const float scale = 1.0f / determinant;
    const float3 from = ray.origin - a, q = cross(from, u);
    const float first = dot(from, p) * scale, second = dot(ray.direction, q) * scale;
    t = dot(v, q) * scale;
    return first >= -1e-5f && second >= -1e-5f && first + second <= 1.00002f && t > ray.tmin &&
           t < ray.tmax;
}

// Reports the nearest of the two triangles of a cell; the attribute is the cell, the kind the
// triangle.
DEVICE bool meetCell(const HeightRecord& r, const FieldRay& ray, int x, int z) {
    const float3 a = vertexAt(r, x, z), b = vertexAt(r, x + 1, z), c = vertexAt(r, x, z + 1),
                 d = vertexAt(r, x + 1, z + 1);
    float first, second;
    const bool meetsFirst = meetTriangle(ray, a, c, b, first);
    const bool meetsSecond = meetTriangle(ray, b, c, d, second);
    if (!meetsFirst && !meetsSecond)
        return false;
    const bool isFirst = meetsFirst && (!meetsSecond || first <= second);
    return optixReportIntersection(isFirst ? first : second, isFirst ? 0 : 1, z * r.across + x);
}

extern "C" __global__ void __intersection__tile() {
    const HeightRecord& r = land();
    const int tile = optixGetPrimitiveIndex();
    const int left = tile % r.tiles * kTileCells, back = tile / r.tiles * kTileCells;
    const HeightRange* const ranges = r.ranges + static_cast<size_t>(tile) * kTileNodes;
    FieldRay ray = {optixGetObjectRayOrigin(), optixGetObjectRayDirection(), vec(0.0f),
                    optixGetRayTmin(), optixGetRayTmax()};
    ray.inverse = vec(1.0f / ray.direction.x, 1.0f / ray.direction.y, 1.0f / ray.direction.z);
    // The child that the ray meets last has this number.
    const unsigned last = (ray.direction.x > 0.0f ? 1u : 0u) | (ray.direction.z > 0.0f ? 2u : 0u);
    unsigned stack[3 * kTileLevels + 1] = {0}; // level, row and column, 8 bits each
    for (int count = 1; count > 0;) {
        const unsigned node = stack[--count];
        const unsigned level = node >> 16, row = node >> 8 & 255, column = node & 255;
        const int side = kTileCells >> level, first = ((1 << 2 * level) - 1) / 3;
        const HeightRange range = ranges[first + (row << level) + column];
        const float x = left + side * column, z = back + side * row;
        if (!clip(ray, vec(x, range.low, z), vec(x + side, range.high, z + side)))
            continue;
        if (level == kTileLevels) {
            if (meetCell(r, ray, left + column, back + row))
                return;
            continue;
        }
        for (unsigned i = 0; i < 4; ++i) {
            const unsigned child = i ^ last;
            stack[count++] =
                (level + 1) << 16 | (2 * row + (child >> 1)) << 8 | (2 * column + (child & 1));
        }
    }
}

DEVICE float3 skyTowards(float3 direction) {
    const float towards = fmaxf(dot(direction, params.sun), 0.0f);
    return lerp(vec(0.75f, 0.8f, 0.88f), vec(0.16f, 0.36f, 0.78f),
                sqrtf(fmaxf(direction.y, 0.0f))) +
           vec(0.9f, 0.6f, 0.35f) * (0.4f * powf(towards, 10.0f) + 6.0f * powf(towards, 1500.0f));
}
DEVICE void answer(float3 color, unsigned random) {
    optixSetPayload_0(__float_as_uint(color.x));
    optixSetPayload_1(__float_as_uint(color.y));
    optixSetPayload_2(__float_as_uint(color.z));
    optixSetPayload_4(random);
}
DEVICE float3 look(float3 from, float3 direction, unsigned depth, unsigned& random) {
    unsigned r, g, b;
    optixTrace(params.land, from, direction, 1e-2f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 0, 0, r, g, b, depth, random);
    return vec(__uint_as_float(r), __uint_as_float(g), __uint_as_float(b));
}
// Whether a ray meets no land; water does not count.
DEVICE bool isOpen(float3 from, float3 direction, float distance) {
    unsigned open = 0, unused = 0;
    optixTrace(params.land, from, direction, 1e-2f, distance, 0.0f, OptixVisibilityMask(1),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 0, 1, open, unused, unused, unused, unused);
    return open != 0;
}
DEVICE float3 throughHaze(float3 color) {
    const float passes = expf(-params.haze * optixGetRayTmax());
    return lerp(
        skyTowards(vec(optixGetWorldRayDirection().x, 0.05f, optixGetWorldRayDirection().z)), color,
        passes);
}

extern "C" __global__ void __closesthit__land() {
    const HeightRecord& r = land();
    unsigned random = optixGetPayload_4();
    const int cell = optixGetAttribute_0(), x = cell % r.across, z = cell / r.across;
    const float3 a = vertexAt(r, x + 1, z), b = vertexAt(r, x, z + 1);
    const float3 c = optixGetHitKind() ? vertexAt(r, x + 1, z + 1) : vertexAt(r, x, z);
    const float3 flat = cross(b - c, a - c);
    const float3 normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(flat)));
    const float3 point = rayPoint() + normal * 0.02f;
    unsigned open = 0;
    for (unsigned i = 0; i < params.skyRays; ++i) {
        const float u = nextFloat(random), v = nextFloat(random);
        open += isOpen(point, cosineDirection(normal, u, v), 150.0f);
    }
    float3 light = vec(0.45f, 0.55f, 0.75f) * (static_cast<float>(open) / params.skyRays);
    const float cosine = dot(normal, params.sun);
    if (cosine > 0.0f && isOpen(point, params.sun, 1e16f))
        light += vec(2.4f, 2.0f, 1.5f) * cosine;
    const float rock = clamp01(4.0f * (0.82f - normal.y)),
                snow = clamp01(0.1f * (point.y - params.snowLine));
    const float3 meadow = lerp(vec(0.2f, 0.3f, 0.1f), vec(0.85f, 0.87f, 0.9f), snow);
    answer(throughHaze(lerp(meadow, vec(0.33f, 0.29f, 0.26f), rock) * light), random);
}

extern "C" __global__ void __closesthit__water() {
    unsigned random = optixGetPayload_4();
    const float3 point = rayPoint(), direction = optixGetWorldRayDirection();
    const float fade = 1.0f / (1.0f + 0.01f * optixGetRayTmax());
    const float3 normal =
        normalize(vec(0.03f * fade * (sinf(0.9f * point.x + 0.4f * point.z) + sinf(2.3f * point.z)),
                      1.0f, 0.03f * fade * sinf(1.1f * point.z - 0.7f * point.x)));
    const float edge = clamp01(1.0f + dot(direction, normal)), squared = edge * edge;
    const float mirrored = 0.03f + 0.97f * squared * squared * edge;
    float3 color = vec(0.02f, 0.08f, 0.1f);
    if (optixGetPayload_3() == 0) {
        float3 away = reflect(direction, normal);
        away.y = fabsf(away.y);
        color = lerp(color, look(point, away, 1, random), mirrored);
    }
    answer(throughHaze(color), random);
}
extern "C" __global__ void __miss__sky() {
    answer(skyTowards(optixGetWorldRayDirection()), optixGetPayload_4());
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

extern "C" __global__ void __raygen__landscape() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        sum += look(params.camera.eye, cameraDirection(params.camera, x, y), 0, random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
