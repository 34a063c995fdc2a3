// SPDX-License-Identifier: Apache-2.0
// Solids with holes: a ray visits the faces of all solids of a part in order, by closest hits with
// a growing tmin, and keeps a set of the solids that it is in. The surface is where the value of
// the part's expression changes. Payload: distance, solid and side, instance, normal.
#include "csg.h"
#include "tools.h"

extern "C" {
__constant__ CsgParams params;
}

constexpr float kFar = 1e16f;
constexpr unsigned kMaxFaces = 160;

struct Crossing {
    float distance; // negative: none
    unsigned solid, isEntry, part;
    float3 normal;
};

extern "C" __global__ void __closesthit__face() {
    const auto* r = reinterpret_cast<const CsgRecord*>(optixGetSbtDataPointer());
    const float3 local = r->mesh.normal(optixGetPrimitiveIndex());
    const float3 normal = normalize(optixTransformNormalFromObjectToWorldSpace(local));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(r->solid << 1 | (optixIsTriangleFrontFaceHit() ? 1u : 0u));
    optixSetPayload_2(optixGetInstanceId());
    optixSetPayload_3(__float_as_uint(normal.x));
    optixSetPayload_4(__float_as_uint(normal.y));
    optixSetPayload_5(__float_as_uint(normal.z));
}
extern "C" __global__ void __miss__nothing() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}

DEVICE Crossing nextCrossing(float3 origin, float3 direction, float from, float to) {
    unsigned distance, face, part, x, y, z;
    optixTrace(params.parts, origin, direction, from, to, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, distance, face, part, x, y, z);
    return {__uint_as_float(distance), face >> 1, face & 1, part,
            vec(__uint_as_float(x), __uint_as_float(y), __uint_as_float(z))};
}

// Whether a point in these solids is in the part; each result is a bit of a stack.
DEVICE bool isInside(const CsgPart& part, unsigned solids) {
    unsigned stack = 0;
    for (unsigned i = 0; i < part.count; ++i) {
        const unsigned step = params.steps[part.first + i];
        if (step < kCsgSolids) {
            stack = stack << 1 | (solids >> step & 1);
            continue;
        }
        const unsigned second = stack & 1, first = stack >> 1 & 1;
        const unsigned result = step == kCsgUnion  ? first | second
                                : step == kCsgBoth ? first & second
                                                   : first & ~second;
        stack = (stack >> 2) << 1 | result;
    }
    return stack & 1;
}

// The part around the origin of a ray, and those of its solids that the origin is in. The origin is
// outside the part, but may be in a solid that the part leaves out.
struct Place {
    unsigned part, solids;
};

// The first surface of a part. Then `place` is that of its outer side.
DEVICE Crossing findSurface(float3 origin, float3 direction, float to, Place& place) {
    unsigned solids = place.solids, part = place.part;
    bool wasInside = false;
    float from = 0.0f;
    Crossing c;
    for (unsigned i = 0; i < kMaxFaces; ++i) {
        c = nextCrossing(origin, direction, from, to);
        if (c.distance < 0.0f)
            return c;
        if (c.part != part) {
            part = c.part;
            solids = 0;
            wasInside = false;
        }
        const unsigned bit = 1u << c.solid, before = solids;
        solids = c.isEntry ? solids | bit : solids & ~bit;
        const bool inside = isInside(params.expressions[part], solids);
        if (inside && !wasInside) {
            place = {part, before};
            return c;
        }
        wasInside = inside;
        from = c.distance + 2e-5f;
    }
    c.distance = -1.0f;
    return c;
}

DEVICE float3 floorColor(float3 point) {
    const int tile = static_cast<int>(floorf(point.x)) + static_cast<int>(floorf(point.z));
    return tile & 1 ? vec(0.55f, 0.56f, 0.6f) : vec(0.4f, 0.41f, 0.44f);
}

constexpr Place kNowhere = {~0u, 0};

struct Seen {
    float3 point, normal, color;
    float mirror, distance;
    Place place;
};
DEVICE bool isOpen(const Seen& from, float3 direction, float reach) {
    Place place = from.place;
    return findSurface(from.point, direction, reach, place).distance < 0.0f;
}
DEVICE Seen lookAlong(float3 origin, float3 direction, Place place) {
    const Crossing c = findSurface(origin, direction, kFar, place);
    const float down = direction.y < 0.0f ? (params.floor - origin.y) / direction.y : kFar;
    if (c.distance >= 0.0f && c.distance < down) {
        const CsgPart& part = params.expressions[c.part];
        const float3 normal = dot(c.normal, direction) > 0.0f ? -c.normal : c.normal;
        return {origin + direction * c.distance + normal * 2e-3f,
                normal,
                part.color,
                part.mirror,
                c.distance,
                place};
    }
    const float3 point = origin + direction * down;
    return {point, vec(0.0f, 1.0f, 0.0f),       floorColor(point),
            0.0f,  down < 80.0f ? down : -1.0f, kNowhere};
}

DEVICE float3 shade(const Seen& seen, unsigned& random) {
    float open = 0.0f;
    for (unsigned i = 0; i < params.openRays; ++i) {
        const float u = nextFloat(random), v = nextFloat(random);
        open += isOpen(seen, cosineDirection(seen.normal, u, v), 2.0f);
    }
    float3 light = vec(0.55f, 0.6f, 0.68f) * (open / params.openRays);
    const float cosine = dot(seen.normal, params.sun);
    if (cosine > 0.0f && isOpen(seen, params.sun, kFar))
        light += vec(1.3f, 1.2f, 1.05f) * cosine;
    return seen.color * light;
}

extern "C" __global__ void __raygen__solids() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        const float3 direction = cameraDirection(params.camera, x, y);
        const Seen seen = lookAlong(params.camera.eye, direction, kNowhere);
        if (seen.distance < 0.0f) {
            sum += blueSky(direction);
            continue;
        }
        float3 color = shade(seen, random);
        if (seen.mirror > 0.0f) {
            const float3 away = reflect(direction, seen.normal);
            const Seen other = lookAlong(seen.point, away, seen.place);
            color = lerp(color, other.distance < 0.0f ? blueSky(away) : shade(other, random),
                         seen.mirror);
        }
        sum += color;
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
