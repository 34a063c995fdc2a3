// SPDX-License-Identifier: Apache-2.0
// Distance fields in boxes: the intersection program steps along the ray by the distance to the
// surface. The closest-hit program takes the normal from six distances and traces a shadow ray and
// rays of ambient occlusion. Payload: the address of the result; for shadow rays one word.
#include "distance_field.h"
#include "tools.h"

extern "C" {
__constant__ FieldParams params;
}

struct PerRay {
    float3 color;
    float distance;
    unsigned seed;
};

// The two payload words of an address.
union AddressWords {
    unsigned long long address;
    uint2 words;
};
DEVICE AddressWords wordsOf(const PerRay* ray) {
    AddressWords w;
    w.address = reinterpret_cast<unsigned long long>(ray);
    return w;
}
DEVICE PerRay* perRay() {
    AddressWords w;
    w.words = make_uint2(optixGetPayload_0(), optixGetPayload_1());
    return reinterpret_cast<PerRay*>(w.address);
}

enum RayKind : unsigned { kViewRay, kOcclusionRay, kRayKinds };

// ---- Distances, in a box from -1 to 1 -----------------------------------------------------------

DEVICE float bulbDistance(float3 p, float power) {
    float3 z = p * 1.2f;
    float derivative = 1.0f, r = length(z);
    for (int i = 0; i < 7 && r < 2.0f; ++i) {
        const float theta = acosf(z.y / fmaxf(r, 1e-6f)) * power;
        const float phi = atan2f(z.z, z.x) * power;
        const float grown = powf(r, power - 1.0f);
        derivative = power * grown * derivative + 1.0f;
        z = vec(sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi)) * (grown * r) +
            p * 1.2f;
        r = length(z);
    }
    return 0.5f * logf(fmaxf(r, 1e-6f)) * r / derivative / 1.2f;
}
DEVICE float boxDistance(float3 p, float side) {
    const float3 q = vec(fabsf(p.x) - side, fabsf(p.y) - side, fabsf(p.z) - side);
    const float3 out = vec(fmaxf(q.x, 0.0f), fmaxf(q.y, 0.0f), fmaxf(q.z, 0.0f));
    return length(out) + fminf(maxComponent(q), 0.0f);
}
DEVICE float spongeDistance(float3 p) {
    float distance = boxDistance(p, 0.95f), scale = 1.0f / 0.95f;
    for (int level = 0; level < 4; ++level) {
        const auto fold = [&](float x) {
            const float y = x * scale + 1.0f;
            return fabsf(1.0f - 3.0f * fabsf(y - 2.0f * floorf(y * 0.5f) - 1.0f));
        };
        const float3 r = vec(fold(p.x), fold(p.y), fold(p.z));
        scale *= 3.0f;
        const float a = fmaxf(r.x, r.y), b = fmaxf(r.y, r.z), c = fmaxf(r.z, r.x);
        distance = fmaxf(distance, (fminf(a, fminf(b, c)) - 1.0f) / scale);
    }
    return distance;
}
DEVICE float gyroidDistance(float3 p, float cells) {
    const float3 q = p * cells;
    const float wave = sinf(q.x) * cosf(q.y) + sinf(q.y) * cosf(q.z) + sinf(q.z) * cosf(q.x);
    const float shell = (fabsf(wave) - 0.25f) / (cells * 1.6f);
    return fmaxf(shell, length(p) - 0.95f);
}
DEVICE float ripplesDistance(float3 p) {
    const float r = sqrtf(p.x * p.x + p.z * p.z);
    const float height = -0.965f + 0.004f * sinf(90.0f * r) + 0.002f * sinf(170.0f * p.x);
    return (p.y - height) * 0.7f;
}
DEVICE float distanceTo(const Field& f, float3 world) {
    const float3 p = (world - f.center) / f.radius;
    float distance = 0.0f;
    switch (f.kind) {
    case kBulb:
        distance = bulbDistance(p, f.parameter);
        break;
    case kSponge:
        distance = spongeDistance(p);
        break;
    case kGyroid:
        distance = gyroidDistance(p, f.parameter);
        break;
    default:
        distance = ripplesDistance(p);
    }
    return distance * f.radius;
}

// ---- Programs -----------------------------------------------------------------------------------

extern "C" __global__ void __intersection__field() {
    const FieldRecord* record = reinterpret_cast<FieldRecord*>(optixGetSbtDataPointer());
    const Field& f = record->fields[optixGetPrimitiveIndex()];
    const float3 origin = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    const float3 o = origin - f.center;
    const float3 slope = make_float3(1.0f / d.x, 1.0f / d.y, 1.0f / d.z);
    const float3 a = vec(-f.radius - o.x, -f.radius - o.y, -f.radius - o.z) * slope;
    const float3 b = vec(f.radius - o.x, f.radius - o.y, f.radius - o.z) * slope;
    float t =
        fmaxf(fmaxf(fminf(a.x, b.x), fminf(a.y, b.y)), fmaxf(fminf(a.z, b.z), optixGetRayTmin()));
    const float end =
        fminf(fminf(fmaxf(a.x, b.x), fmaxf(a.y, b.y)), fminf(fmaxf(a.z, b.z), optixGetRayTmax()));
    for (unsigned step = 0; step < 96 && t < end; ++step) {
        const float distance = distanceTo(f, origin + d * t);
        if (distance < record->precision) {
            optixReportIntersection(t, 0, step);
            return;
        }
        t += distance;
    }
}

DEVICE float3 normalAt(const Field& f, float3 p, float h) {
    return normalize(vec(distanceTo(f, p + vec(h, 0, 0)) - distanceTo(f, p - vec(h, 0, 0)),
                         distanceTo(f, p + vec(0, h, 0)) - distanceTo(f, p - vec(0, h, 0)),
                         distanceTo(f, p + vec(0, 0, h)) - distanceTo(f, p - vec(0, 0, h))) +
                     vec(0.0f, 1e-9f, 0.0f));
}
DEVICE bool isBlocked(float3 origin, float3 direction, float tmin, float tmax) {
    unsigned blocked = 1, unused = 0;
    optixTrace(params.root, origin, direction, tmin, tmax, 0.0f, OptixVisibilityMask(1),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               kOcclusionRay, kRayKinds, kOcclusionRay, blocked, unused);
    return blocked != 0;
}

extern "C" __global__ void __closesthit__field() {
    const FieldRecord* record = reinterpret_cast<FieldRecord*>(optixGetSbtDataPointer());
    const Field& f = record->fields[optixGetPrimitiveIndex()];
    PerRay* ray = perRay();
    const float3 p = rayPoint();
    const float3 normal = normalAt(f, p, 2.0f * record->precision);
    const float3 start = p + normal * (4.0f * record->precision);
    const float cosine = dot(normal, params.sun);
    float3 light = vec(0.0f);
    if (cosine > 0.0f && !isBlocked(start, params.sun, 0.0f, 1e16f))
        light += vec(1.5f, 1.4f, 1.2f) * cosine;
    float open = 0.0f;
    for (int i = 0; i < 4; ++i) {
        const float u = nextFloat(ray->seed), v = nextFloat(ray->seed);
        open += isBlocked(start, cosineDirection(normal, u, v), 0.0f, 0.5f) ? 0.0f : 0.25f;
    }
    light += blueSky(normal) * (0.6f * open);
    const float crowded = 1.0f - optixGetAttribute_0() / 160.0f; // many steps: a crevice
    ray->color = f.color * light * crowded;
    ray->distance = optixGetRayTmax();
}

extern "C" __global__ void __miss__view() {
    PerRay* ray = perRay();
    ray->color = blueSky(optixGetWorldRayDirection());
    ray->distance = -1.0f;
}
extern "C" __global__ void __miss__occlusion() {
    optixSetPayload_0(0u);
}

extern "C" __global__ void __raygen__field() {
    const uint3 idx = optixGetLaunchIndex();
    const unsigned pixel = idx.y * params.width + idx.x;
    PerRay ray;
    ray.seed = hashPcg(pixel);
    AddressWords payload = wordsOf(&ray);
    optixTrace(params.root, params.camera.eye,
               cameraDirection(params.camera, (idx.x + 0.5f) / params.width,
                               (idx.y + 0.5f) / params.height),
               0.0f, 1e16f, 0.0f, OptixVisibilityMask(1), OPTIX_RAY_FLAG_NONE, kViewRay, kRayKinds,
               kViewRay, payload.words.x, payload.words.y);
    params.frame[pixel] = withWeight(ray.color, ray.distance);
}
