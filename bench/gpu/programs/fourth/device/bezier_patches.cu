// SPDX-License-Identifier: Apache-2.0
// Bicubic patches, which an intersection program meets by Newton's iteration from several places.
// Ray generation hands hits to continuation callables, which trace further rays. Payload: distance,
// instance, normal.
#include "bezier_patches.h"
#include "tools.h"

extern "C" {
__constant__ BezierParams params;
}

constexpr int kSteps = 7, kStarts = 5;

struct PatchPoint {
    float3 at, alongU, alongV;
};
struct PatchHit {
    float distance; // negative: none
    unsigned instance;
    float3 point, normal, eye;
};

// Values and slopes of the four cubic polynomials.
DEVICE void bernstein(float x, float values[4], float slopes[4]) {
    const float y = 1.0f - x;
    values[0] = y * y * y;
    values[1] = 3.0f * x * y * y;
    values[2] = 3.0f * x * x * y;
    values[3] = x * x * x;
    slopes[0] = -3.0f * y * y;
    slopes[1] = 3.0f * y * (y - 2.0f * x);
    slopes[2] = 3.0f * x * (2.0f * y - x);
    slopes[3] = 3.0f * x * x;
}
DEVICE PatchPoint evaluate(const BezierPatch& patch, float u, float v) {
    float a[4], da[4], b[4], db[4];
    bernstein(u, a, da);
    bernstein(v, b, db);
    PatchPoint p = {vec(0.0f), vec(0.0f), vec(0.0f)};
    for (int row = 0; row < 4; ++row) {
        float3 at = vec(0.0f), along = vec(0.0f);
        for (int column = 0; column < 4; ++column) {
            at += patch.points[4 * row + column] * a[column];
            along += patch.points[4 * row + column] * da[column];
        }
        p.at += at * b[row];
        p.alongU += along * b[row];
        p.alongV += at * db[row];
    }
    return p;
}

// The place of the patch on a ray, from a first guess: Newton's iteration on the distances to two
// planes through the ray. False if it leaves the patch.
DEVICE bool refine(const BezierPatch& patch, float3 origin, float3 x, float3 y, float& u, float& v,
                   float3& at) {
    for (int i = 0; i < kSteps; ++i) {
        const PatchPoint p = evaluate(patch, u, v);
        const float3 from = p.at - origin;
        const float f = dot(from, x), g = dot(from, y);
        const float fu = dot(p.alongU, x), fv = dot(p.alongV, x), gu = dot(p.alongU, y),
                    gv = dot(p.alongV, y);
        const float determinant = fu * gv - fv * gu;
        if (fabsf(determinant) < 1e-14f)
            return false;
        const float du = (f * gv - g * fv) / determinant, dv = (g * fu - f * gu) / determinant;
        u -= du;
        v -= dv;
        if (fabsf(u - 0.5f) > 2.0f || fabsf(v - 0.5f) > 2.0f)
            return false;
        if (fabsf(du) + fabsf(dv) < 1e-5f)
            break;
    }
    at = evaluate(patch, u, v).at;
    return u >= -1e-4f && u <= 1.0001f && v >= -1e-4f && v <= 1.0001f;
}

extern "C" __global__ void __intersection__patch() {
    const auto* r = reinterpret_cast<const BezierRecord*>(optixGetSbtDataPointer());
    const BezierPatch& patch = r->patches[optixGetPrimitiveIndex()];
    const float3 origin = optixGetObjectRayOrigin(), d = optixGetObjectRayDirection();
    const float squared = dot(d, d);
    float3 x, y;
    makeBasis(d / sqrtf(squared), x, y);
    float best = optixGetRayTmax(), bestU = 0.0f, bestV = 0.0f;
    for (int i = 0; i < kStarts; ++i) {
        float u = i == 0 ? 0.5f : i & 1 ? 0.2f : 0.8f, v = i == 0 ? 0.5f : i & 2 ? 0.2f : 0.8f;
        float3 at;
        if (!refine(patch, origin, x, y, u, v, at))
            continue;
        const float t = dot(at - origin, d) / squared;
        const float3 off = at - origin - d * t;
        if (t > optixGetRayTmin() && t < best && dot(off, off) < 1e-8f) {
            best = t;
            bestU = u;
            bestV = v;
        }
    }
    if (best < optixGetRayTmax())
        optixReportIntersection(best, 0, __float_as_uint(bestU), __float_as_uint(bestV));
}

DEVICE void answer(float3 normal) {
    normal = towardsRay(normalize(optixTransformNormalFromObjectToWorldSpace(normal)));
    optixSetPayload_0(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_1(optixGetInstanceId());
    optixSetPayload_2(__float_as_uint(normal.x));
    optixSetPayload_3(__float_as_uint(normal.y));
    optixSetPayload_4(__float_as_uint(normal.z));
}
extern "C" __global__ void __closesthit__patch() {
    const auto* r = reinterpret_cast<const BezierRecord*>(optixGetSbtDataPointer());
    const PatchPoint p =
        evaluate(r->patches[optixGetPrimitiveIndex()], __uint_as_float(optixGetAttribute_0()),
                 __uint_as_float(optixGetAttribute_1()));
    answer(cross(p.alongU, p.alongV));
}
extern "C" __global__ void __closesthit__floor() {
    answer(vec(0.0f, 1.0f, 0.0f));
}
extern "C" __global__ void __miss__sky() {
    optixSetPayload_0(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__open() {
    optixSetPayload_0(1);
}

DEVICE PatchHit find(float3 from, float3 direction) {
    unsigned distance, instance, x, y, z;
    optixTrace(params.gallery, from, direction, 0.0f, 1e16f, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, distance, instance, x, y, z);
    PatchHit hit;
    hit.distance = __uint_as_float(distance);
    hit.instance = instance;
    hit.normal = vec(__uint_as_float(x), __uint_as_float(y), __uint_as_float(z));
    hit.point = from + direction * hit.distance + hit.normal * 2e-3f;
    hit.eye = -direction;
    return hit;
}
DEVICE bool isOpen(float3 from, float3 direction, float reach) {
    unsigned open = 0, unused = 0;
    optixTrace(params.gallery, from, direction, 0.0f, reach, 0.0f, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
                   OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
               0, 1, 1, open, unused, unused, unused, unused);
    return open != 0;
}

DEVICE float3 colorOf(const PatchHit& hit) {
    if (hit.instance == 0) {
        const float stripe = hit.point.x + 0.5f * sinf(hit.point.z);
        return stripe - floorf(stripe) < 0.5f ? vec(0.62f, 0.58f, 0.5f) : vec(0.5f, 0.46f, 0.4f);
    }
    const unsigned bits = hashPcg(hit.instance);
    return vec(0.25f) + vec(bits & 255, bits >> 8 & 255, bits >> 16 & 255) * (0.65f / 255.0f);
}
// Sun and sky that arrive at a surface.
DEVICE float3 lightAt(const PatchHit& hit, unsigned& random) {
    float open = 0.0f;
    for (unsigned i = 0; i < params.openRays; ++i) {
        const float u = nextFloat(random), v = nextFloat(random);
        open += isOpen(hit.point, cosineDirection(hit.normal, u, v), params.reach);
    }
    float3 light = blueSky(hit.normal) * (0.6f * open / params.openRays);
    const float cosine = dot(hit.normal, params.sun);
    if (cosine > 0.0f && isOpen(hit.point, params.sun, 1e16f))
        light += vec(1.4f, 1.3f, 1.1f) * cosine;
    return light;
}

extern "C" __device__ float3 __continuation_callable__ceramic(const PatchHit& hit,
                                                              unsigned& random) {
    const float3 shine = reflect(-hit.eye, hit.normal);
    const float glint = powf(fmaxf(dot(shine, params.sun), 0.0f), 60.0f);
    return colorOf(hit) * lightAt(hit, random) + vec(0.4f * glint);
}
extern "C" __device__ float3 __continuation_callable__chrome(const PatchHit& hit,
                                                             unsigned& random) {
    const float3 direction = reflect(-hit.eye, hit.normal);
    const PatchHit other = find(hit.point, direction);
    const float3 seen =
        other.distance < 0.0f ? blueSky(direction) : colorOf(other) * lightAt(other, random);
    return lerp(colorOf(hit), vec(1.0f), 0.6f) * seen;
}
extern "C" __device__ float3 __continuation_callable__velvet(const PatchHit& hit,
                                                             unsigned& random) {
    const float edge = 1.0f - fabsf(dot(hit.eye, hit.normal));
    return (colorOf(hit) * 0.5f + vec(0.5f * edge * edge)) * lightAt(hit, random);
}

extern "C" __global__ void __raygen__gallery() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned pixel = index.y * size.x + index.x;
    unsigned random = hashPcg(pixel);
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < params.samples; ++i) {
        const float x = (index.x + nextFloat(random)) / size.x;
        const float y = (index.y + nextFloat(random)) / size.y;
        const float3 direction = cameraDirection(params.camera, x, y);
        const PatchHit hit = find(params.camera.eye, direction);
        sum += hit.distance < 0.0f ? blueSky(direction)
                                   : optixContinuationCall<float3, const PatchHit&, unsigned&>(
                                         hit.instance % kPatchShadings, hit, random);
    }
    params.image[pixel] = withWeight(sum / float(params.samples), 1.0f);
}
