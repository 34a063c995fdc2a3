// SPDX-License-Identifier: Apache-2.0
// The programs of the classic API.
#include <optix_world.h>

#include "shade.h"

using namespace optix;

struct Radiance {
    float3 color;
    float distance;
    unsigned bounce;
};
struct Shadow {
    float light;
};

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(rtObject, top_object, , );
rtBuffer<float4, 2> picture;

RT_PROGRAM void draw() {
    Radiance result;
    result.bounce = 0;
    result.distance = -1.0f;
    const float3 d = shade::direction(launch_index.x, launch_index.y, launch_dim.x, launch_dim.y);
    rtTrace(top_object, make_Ray(shade::eye(), d, shade::kRadiance, shade::kEpsilon, shade::kFar),
            result);
    picture[launch_index] = make_float4(result.color, result.distance);
}

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(Radiance, radiance, rtRayPayload, );
rtDeclareVariable(Shadow, shadow, rtRayPayload, );
rtDeclareVariable(float3, albedo, , );
rtBuffer<float3> vertices;
rtBuffer<uint3> triangles;
rtBuffer<float4> spheres;

RT_PROGRAM void miss() {
    radiance.color = shade::sky(ray.direction);
}

static __device__ float lightAt(float3 point) {
    Shadow result;
    result.light = 1.0f;
    rtTrace(top_object,
            make_Ray(point, shade::toSun(), shade::kShadow, shade::kEpsilon, shade::kFar), result);
    return result.light;
}

rtDeclareVariable(float2, barycentrics, attribute barycentrics, );
rtDeclareVariable(float3, normal, attribute normal, );

RT_PROGRAM void hit_triangle() {
    const uint3 t = triangles[rtGetPrimitiveIndex()];
    const float3 a = vertices[t.x], b = vertices[t.y], c = vertices[t.z];
    const float3 face = shade::outer(shade::minus(b, a), shade::minus(c, a));
    const float3 world = shade::unit(rtTransformNormal(RT_OBJECT_TO_WORLD, face));
    const float3 n = shade::facing(world, ray.direction);
    const float3 point = shade::plus(ray.origin, shade::times(ray.direction, hit_distance));
    radiance.color = shade::diffuse(albedo, n, lightAt(point));
    radiance.distance = hit_distance;
}
RT_PROGRAM void hit_sphere() {
    const float3 world = shade::unit(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float3 n = shade::facing(world, ray.direction);
    const float3 point = shade::plus(ray.origin, shade::times(ray.direction, hit_distance));
    float3 color = shade::diffuse(albedo, n, lightAt(point));
    if (radiance.bounce < shade::kMaxBounce) {
        Radiance next;
        next.bounce = radiance.bounce + 1;
        rtTrace(top_object,
                make_Ray(point, shade::mirror(ray.direction, n), shade::kRadiance, shade::kEpsilon,
                         shade::kFar),
                next);
        color = shade::plus(color, shade::times(next.color, 0.4f));
    }
    radiance.color = color;
    radiance.distance = hit_distance;
}

RT_PROGRAM void block() {
    shadow.light = 0.0f;
    rtTerminateRay();
}
RT_PROGRAM void cut() {
    if (shade::isHole(rtGetPrimitiveIndex(), barycentrics))
        rtIgnoreIntersection();
}
RT_PROGRAM void dim() {
    if (!shade::isHole(rtGetPrimitiveIndex(), barycentrics))
        shadow.light *= 0.5f;
    rtIgnoreIntersection();
}

static __device__ bool report(float4 sphere, float t) {
    if (!rtPotentialIntersection(t))
        return false;
    normal = shade::sphereNormal(ray.origin, ray.direction, sphere, t);
    return rtReportIntersection(0);
}
RT_PROGRAM void intersect_spheres(int primitive) {
    const float4 sphere = spheres[primitive];
    float near, far;
    if (shade::hitSphere(ray.origin, ray.direction, sphere, near, far) && !report(sphere, near))
        report(sphere, far);
}
RT_PROGRAM void bound_spheres(int primitive, float box[6]) {
    const float4 s = spheres[primitive];
    const float values[6] = {s.x - s.w, s.y - s.w, s.z - s.w, s.x + s.w, s.y + s.w, s.z + s.w};
    for (int i = 0; i < 6; ++i)
        box[i] = values[i];
}
