// SPDX-License-Identifier: Apache-2.0
// Surfaces without triangles: the intersection program steps along the ray by distances to the
// surface (Hart 1996). A variable of the geometry selects the surface.
#include "../device6.h"
#include "shape_kinds.h"

using namespace optix;

enum RayType { kRadianceRay, kShadowRay };

struct Radiance {
    float3 color;
};
struct Shadow {
    int blocked;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(float, scene_epsilon, , );
rtBuffer<float4, 2> picture;

RT_PROGRAM void camera() {
    float3 sum = make_float3(0.0f);
    for (int i = 0; i < 4; ++i) {
        const float x = (i % 2) * 0.5f + (i / 2) * 0.25f + 0.125f;
        Radiance result;
        const Ray ray = make_Ray(eye, cameraDirection(x, i * 0.25f + 0.125f), kRadianceRay,
                                 scene_epsilon, RT_DEFAULT_MAX);
        rtTrace(top_object, ray, result);
        sum += result.color;
    }
    picture[launch_index] = make_float4(sum * 0.25f, 1.0f);
}
RT_PROGRAM void show_exception() {
    rtPrintExceptionDetails();
    picture[launch_index] = make_float4(1.0f, 0.0f, 1.0f, 1.0f);
}

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(Radiance, radiance, rtRayPayload, );
rtDeclareVariable(Shadow, shadow, rtRayPayload, );
rtDeclareVariable(float3, normal, attribute normal, );
rtDeclareVariable(float, crevice, attribute crevice, "steps of the walk, of all");

RT_PROGRAM void miss() {
    radiance.color =
        lerp(make_float3(0.9f), make_float3(0.35f, 0.45f, 0.6f), fabsf(ray.direction.y));
}

rtDeclareVariable(float3, color, , );
rtDeclareVariable(float3, sun, , );
RT_PROGRAM void hit() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float3 n = faceforward(world, -ray.direction, world);
    const float3 point = ray.origin + hit_distance * ray.direction + 4.0f * scene_epsilon * n;
    Shadow result;
    result.blocked = 0;
    rtTrace(top_object, make_Ray(point, sun, kShadowRay, scene_epsilon, RT_DEFAULT_MAX), result);
    const float cosine = result.blocked ? 0.0f : fmaxf(dot(n, sun), 0.0f);
    const float3 half = normalize(sun - ray.direction);
    const float gloss = result.blocked ? 0.0f : 0.4f * powf(fmaxf(dot(n, half), 0.0f), 60.0f);
    const float sky = 0.3f * (0.6f + 0.4f * n.y) * (1.0f - crevice);
    radiance.color = color * (sky + 0.9f * cosine) + make_float3(gloss);
}
RT_PROGRAM void block_light() {
    shadow.blocked = 1;
    rtTerminateRay();
}

// ---- Distances ---------------------------------------------------------------------------------

rtDeclareVariable(int, shape, , "a value of ShapeKind");
rtDeclareVariable(float3, box_low, , );
rtDeclareVariable(float3, box_high, , );

static __device__ __forceinline__ float boxDistance(float3 p, float3 half) {
    const float3 d = make_float3(fabsf(p.x), fabsf(p.y), fabsf(p.z)) - half;
    return length(fmaxf(d, make_float3(0.0f))) + fminf(fmaxf(d), 0.0f);
}
// A cube without its three round bores, as an intersection of distances.
static __device__ float boredCube(float3 p) {
    const float bores = fminf(fminf(length(make_float2(p.x, p.y)), length(make_float2(p.y, p.z))),
                              length(make_float2(p.z, p.x))) -
                        0.55f;
    return fmaxf(fmaxf(boxDistance(p, make_float3(0.75f)) - 0.05f, -bores), length(p) - 1.15f);
}
// A torus whose tube is a square that turns.
static __device__ float twistedRing(float3 p) {
    const float angle = atan2f(p.z, p.x) * 2.0f;
    const float x = length(make_float2(p.x, p.z)) - 0.8f;
    const float c = cosf(angle), s = sinf(angle);
    const float3 turned = make_float3(c * x - s * p.y, s * x + c * p.y, 0.0f);
    return (boxDistance(turned, make_float3(0.2f, 0.2f, 1.0f)) - 0.06f) * 0.7f;
}
// A quaternion Julia set: the distance is an estimate (Hart, Sandin, Kauffman 1989).
static __device__ float julia(float3 p) {
    const float4 c = make_float4(-0.291f, -0.399f, 0.339f, 0.437f);
    float4 z = make_float4(p.x, p.y, p.z, 0.0f);
    float slope = 1.0f, square = dot(z, z);
    for (int i = 0; i < 11 && square < 16.0f; ++i) {
        slope *= 4.0f * square;
        const float3 v = make_float3(z.y, z.z, z.w);
        z = make_float4(z.x * z.x - dot(v, v), 2.0f * z.x * v.x, 2.0f * z.x * v.y,
                        2.0f * z.x * v.z) +
            c;
        square = dot(z, z);
    }
    return 0.25f * sqrtf(square / slope) * logf(square);
}
static __device__ float distanceTo(float3 p) {
    return shape == kBoredCube ? boredCube(p) : shape == kTwistedRing ? twistedRing(p) : julia(p);
}
static __device__ float3 gradient(float3 p) {
    const float h = 5e-4f;
    return make_float3(distanceTo(p + make_float3(h, 0, 0)) - distanceTo(p - make_float3(h, 0, 0)),
                       distanceTo(p + make_float3(0, h, 0)) - distanceTo(p - make_float3(0, h, 0)),
                       distanceTo(p + make_float3(0, 0, h)) - distanceTo(p - make_float3(0, 0, h)));
}

RT_PROGRAM void intersect_shape(int) {
    constexpr int kSteps = 160;
    const float scale = length(ray.direction);
    const float3 d = ray.direction / scale;
    const float3 low = (box_low - ray.origin) / d, high = (box_high - ray.origin) / d;
    float t = fmaxf(fmaxf(fminf(low, high)), ray.tmin * scale);
    const float end = fminf(fmaxf(low, high));
    for (int i = 0; i < kSteps && t < end; ++i) {
        const float step = distanceTo(ray.origin + t * d);
        if (step < scene_epsilon) {
            if (rtPotentialIntersection(t / scale)) {
                normal = gradient(ray.origin + t * d);
                crevice = float(i) / kSteps;
                rtReportIntersection(0);
            }
            return;
        }
        t += step;
    }
}
RT_PROGRAM void bound_shape(int, float result[6]) {
    Aabb* box = (Aabb*)result;
    box->set(box_low, box_high);
}

// The ground of shapes.cu has no crevices.
RT_PROGRAM void hit_ground() {
    const float3 point = ray.origin + hit_distance * ray.direction;
    Shadow result;
    result.blocked = 0;
    rtTrace(top_object, make_Ray(point, sun, kShadowRay, scene_epsilon, RT_DEFAULT_MAX), result);
    const int parity = (int(floorf(point.x)) + int(floorf(point.z))) & 1;
    const float far = 1.0f - expf(-0.004f * hit_distance * hit_distance);
    const float3 lit = make_float3(parity ? 0.5f : 0.35f) * (result.blocked ? 0.35f : 1.1f);
    radiance.color = lerp(lit, make_float3(0.9f), far);
}
