// SPDX-License-Identifier: Apache-2.0
// Rays with times: each path has a time, which rtTrace applies to all nodes with motion keys. Rays
// that closest-hit programs trace have the time of the ray that hit.
#include "../device6.h"

using namespace optix;

enum RayType { kRadianceRay, kShadowRay };

struct Radiance {
    float3 color;
    unsigned seed;
};
struct Shadow {
    int blocked;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(float, scene_epsilon, , );
rtDeclareVariable(unsigned, samples, , );
rtBuffer<float4, 2> picture;

RT_PROGRAM void camera() {
    unsigned seed = hash(launch_index.x + launch_dim.x * launch_index.y);
    float3 sum = make_float3(0.0f);
    for (unsigned i = 0; i < samples; ++i) {
        const float x = random(seed), y = random(seed);
        const float time = (i + random(seed)) / samples; // a stratum for each path
        Radiance result;
        result.seed = seed;
        const Ray ray =
            make_Ray(eye, cameraDirection(x, y), kRadianceRay, scene_epsilon, RT_DEFAULT_MAX);
        rtTrace(top_object, ray, time, result);
        sum += result.color;
        seed = result.seed;
    }
    picture[launch_index] = make_float4(sum / float(samples), 1.0f);
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
rtDeclareVariable(float3, color, , "of the instance or its material");
rtDeclareVariable(float3, sun, , "direction to it");

RT_PROGRAM void miss() {
    radiance.color =
        lerp(make_float3(0.85f), make_float3(0.4f, 0.55f, 0.85f), fmaxf(ray.direction.y, 0.0f));
}

static __device__ __forceinline__ int isBlocked(float3 point, float3 direction, float distance) {
    Shadow result;
    result.blocked = 0;
    const Ray probe = make_Ray(point, direction, kShadowRay, scene_epsilon, distance);
    rtTrace(top_object, probe, result);
    return result.blocked;
}

// The sun, and a probe of the sky.
RT_PROGRAM void hit() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float3 n = faceforward(world, -ray.direction, world);
    const float3 point = ray.origin + hit_distance * ray.direction;
    float3 light = make_float3(0.0f);
    const float cosine = dot(n, sun);
    if (cosine > 0.0f && !isBlocked(point, sun, RT_DEFAULT_MAX))
        light += make_float3(1.0f, 0.95f, 0.85f) * cosine;
    float3 direction;
    const float u = random(radiance.seed), v = random(radiance.seed);
    cosine_sample_hemisphere(u, v, direction);
    Onb(n).inverse_transform(direction);
    if (!isBlocked(point, direction, 4.0f))
        light += make_float3(0.4f, 0.45f, 0.55f);
    radiance.color = color * light;
}
RT_PROGRAM void block_light() {
    shadow.blocked = 1;
    rtTerminateRay();
}

// ---- Triangles: flat normals, at the time of the ray for those in motion
// -----------------------------

rtDeclareVariable(float, current_time, rtCurrentTime, );
rtBuffer<float3> vertices;
rtBuffer<float3> end_vertices; // at time 1
rtBuffer<uint3> triangles;

RT_PROGRAM void triangle_attributes() {
    const uint3 t = triangles[rtGetPrimitiveIndex()];
    const float3 a = lerp(vertices[t.x], end_vertices[t.x], current_time);
    const float3 b = lerp(vertices[t.y], end_vertices[t.y], current_time);
    const float3 c = lerp(vertices[t.z], end_vertices[t.z], current_time);
    normal = cross(b - a, c - a);
}
