// SPDX-License-Identifier: Apache-2.0
// One path for each pixel and launch. With ordinary launches the program accumulates: one buffer
// has the sum of all launches, another the picture. With progressive launches the library
// accumulates.
#include "../device6.h"

using namespace optix;

enum RayType { kPathRay, kShadowRay };

struct Path {
    float3 origin, direction;
    float3 weight, light;
    unsigned seed;
    int done;
};
struct Shadow {
    int blocked;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(float, scene_epsilon, , );
rtDeclareVariable(unsigned, frame, , "launches before this one");
rtDeclareVariable(unsigned, subframe, rtSubframeIndex, );
rtDeclareVariable(unsigned, max_depth, , );
rtBuffer<float4, 2> sum;
rtBuffer<float4, 2> picture;
rtBuffer<float> noise; // by row: the summed difference between this path and the mean

static __device__ __forceinline__ float3 tracePath(unsigned number) {
    unsigned seed = hash(launch_index.x + launch_dim.x * (launch_index.y + launch_dim.y * number));
    Path path;
    path.origin = eye;
    const float x = random(seed), y = random(seed);
    path.direction = cameraDirection(x, y);
    path.weight = make_float3(1.0f);
    path.light = make_float3(0.0f);
    path.seed = seed;
    path.done = 0;
    for (unsigned depth = 0; depth < max_depth && !path.done; ++depth) {
        const Ray ray =
            make_Ray(path.origin, path.direction, kPathRay, scene_epsilon, RT_DEFAULT_MAX);
        rtTrace(top_object, ray, path);
    }
    return path.light;
}

// A subframe of a progressive launch.
RT_PROGRAM void one_path() {
    picture[launch_index] = make_float4(tracePath(subframe), 1.0f);
}

RT_PROGRAM void add_path() {
    const float3 light = tracePath(frame);
    const float4 before = frame == 0 ? make_float4(0.0f) : sum[launch_index];
    const float4 now = before + make_float4(light, 1.0f);
    sum[launch_index] = now;
    picture[launch_index] = now / now.w;
    const float difference = luminance(light) - luminance(make_float3(now) / now.w);
    atomicAdd(&noise[launch_index.y], difference * difference);
}
RT_PROGRAM void show_exception() {
    rtPrintExceptionDetails();
    picture[launch_index] = make_float4(1.0f, 0.0f, 1.0f, 1.0f);
}

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(Path, path, rtRayPayload, );
rtDeclareVariable(Shadow, shadow, rtRayPayload, );
rtDeclareVariable(float3, shading_normal, attribute shading_normal, );

RT_PROGRAM void miss() {
    const float height = fmaxf(path.direction.y, 0.0f);
    path.light += path.weight * lerp(make_float3(0.65f), make_float3(0.25f, 0.45f, 0.85f), height);
    path.done = 1;
}

rtDeclareVariable(float3, albedo, , );
rtDeclareVariable(float, gloss, , "share of light that is mirrored") = 0.0f;
rtDeclareVariable(float3, lamp_place, , );
rtDeclareVariable(float, lamp_radius, , );
rtDeclareVariable(float3, lamp_power, , );

static __device__ __forceinline__ float3 lampLight(float3 point, float3 n) {
    const float u = random(path.seed), v = random(path.seed);
    const float z = 1.0f - 2.0f * u, r = sqrtf(fmaxf(0.0f, 1.0f - z * z)), turn = 2.0f * M_PIf * v;
    const float3 way =
        lamp_place + lamp_radius * make_float3(r * cosf(turn), z, r * sinf(turn)) - point;
    const float distance = length(way), cosine = dot(n, way) / distance;
    if (cosine <= 0.0f)
        return make_float3(0.0f);
    Shadow result;
    result.blocked = 0;
    const Ray probe = make_Ray(point, way / distance, kShadowRay, scene_epsilon, distance);
    rtTrace(top_object, probe, result);
    return result.blocked ? make_float3(0.0f) : lamp_power * (cosine / (distance * distance));
}

RT_PROGRAM void hit() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, shading_normal));
    const float3 n = faceforward(world, -ray.direction, world);
    path.origin = ray.origin + hit_distance * ray.direction;
    const float mirrored = fresnel_schlick(dot(n, -ray.direction), 5.0f, gloss, 1.0f);
    if (gloss > 0.0f && random(path.seed) < mirrored) {
        path.direction = reflect(ray.direction, n);
        return;
    }
    path.weight *= albedo;
    path.light += path.weight * lampLight(path.origin, n);
    const float u = random(path.seed), v = random(path.seed);
    cosine_sample_hemisphere(u, v, path.direction);
    Onb(n).inverse_transform(path.direction);
}
RT_PROGRAM void block_light() {
    shadow.blocked = 1;
    rtTerminateRay();
}

rtBuffer<float3> normals;
rtBuffer<uint3> triangles;

RT_PROGRAM void triangle_attributes() {
    const uint3 t = triangles[rtGetPrimitiveIndex()];
    const float2 b = rtGetTriangleBarycentrics();
    shading_normal = normals[t.x] * (1.0f - b.x - b.y) + normals[t.y] * b.x + normals[t.z] * b.y;
}
