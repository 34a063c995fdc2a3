// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optixu/optixu_aabb_namespace.h>
#include <optixu/optixu_math_namespace.h>

using namespace optix;

struct Seen {
    int body;
    float distance;
    float3 center; // of the body that was hit, in the world
    float3 normal;
    int any; // any-hit programs that ran
};

rtDeclareVariable(rtObject, sky, , );
rtDeclareVariable(unsigned int, slot, rtLaunchIndex, );
rtDeclareVariable(unsigned int, slots, rtLaunchDim, );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(float, now, rtCurrentTime, );
rtDeclareVariable(Seen, seen, rtPayload, );

struct Query {
    float3 origin, direction;
    float time;
    unsigned int mask;
};
rtBuffer<Query, 1> queries;
rtBuffer<Seen, 1> answers;

RT_PROGRAM void ask() {
    const Query query = queries[slot];
    Seen result;
    result.body = -1;
    result.distance = -1;
    result.center = result.normal = make_float3(0);
    result.any = 0;
    const Ray line = make_Ray(query.origin, query.direction, 0, 0.0f, RT_DEFAULT_MAX);
    rtTrace(sky, line, query.time, result, (RTvisibilitymask)query.mask);
    answers[slot] = result;
}

// ---- spheres
rtDeclareVariable(int, body, , ) = -2;
rtDeclareVariable(float, radius, , ) = 1.0f;
rtDeclareVariable(float3, surface, attribute surface, );

RT_PROGRAM void ball_bounds(int, float result[6]) {
    Aabb* box = (Aabb*)result;
    box->set(make_float3(-radius), make_float3(radius));
}
RT_PROGRAM void ball(int) {
    const float a = dot(ray.direction, ray.direction), b = dot(ray.origin, ray.direction),
                c = dot(ray.origin, ray.origin) - radius * radius, d = b * b - a * c;
    if (d < 0)
        return;
    const float t = (-b - sqrtf(d)) / a;
    if (rtPotentialIntersection(t)) {
        surface = (ray.origin + t * ray.direction) / radius;
        rtReportIntersection(0);
    }
}

// ---- programs of materials
RT_PROGRAM void pass() {
    ++seen.any;
}
RT_PROGRAM void note() {
    seen.body = body;
    seen.distance = t_hit;
    seen.center = rtTransformPoint(RT_OBJECT_TO_WORLD, make_float3(0));
    seen.normal = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, surface));
}

// ---- the choice of a selector: near bodies by time, far ones by the ray's origin
rtDeclareVariable(float, switch_time, , );
RT_PROGRAM void by_time() {
    rtIntersectChild(now < switch_time ? 0 : 1);
}
RT_PROGRAM void by_height() {
    if (ray.origin.y > 0)
        rtIntersectChild(0);
    rtIntersectChild(1);
}
