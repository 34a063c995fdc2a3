// SPDX-License-Identifier: Apache-2.0
// A path tracer of few samples for a box with spheres. In addition to the colours it writes the
// denoiser's guides: the albedo and the normal, in camera space, of the first hit.
#include "../device6.h"

using namespace optix;

enum RayType { kPathRay, kShadowRay };

struct Path {
    float3 origin, direction; // of the next segment
    float3 weight, light;
    float3 albedo, normal; // of the hit
    unsigned seed;
    int sees_light; // whether a light that is hit counts
    int done;
};
struct Shadow {
    int blocked;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(float, scene_epsilon, , );
rtDeclareVariable(unsigned, samples, , );
rtDeclareVariable(unsigned, max_depth, , );
rtBuffer<float4, 2> noisy;
rtBuffer<float4, 2> albedo_guide;
rtBuffer<float4, 2> normal_guide;

RT_PROGRAM void trace_paths() {
    unsigned seed = hash(launch_index.x + launch_dim.x * launch_index.y);
    float3 sum = make_float3(0.0f), albedos = sum, normals = sum;
    for (unsigned i = 0; i < samples; ++i) {
        Path path;
        path.origin = eye;
        const float x = random(seed), y = random(seed);
        path.direction = cameraDirection(x, y);
        path.weight = make_float3(1.0f);
        path.light = path.albedo = path.normal = make_float3(0.0f);
        path.seed = seed;
        path.sees_light = 1;
        path.done = 0;
        for (unsigned depth = 0; depth < max_depth && !path.done; ++depth) {
            const Ray ray =
                make_Ray(path.origin, path.direction, kPathRay, scene_epsilon, RT_DEFAULT_MAX);
            rtTrace(top_object, ray, path);
            if (depth == 0) {
                albedos += path.albedo;
                normals += make_float3(dot(path.normal, normalize(camera_right)),
                                       dot(path.normal, normalize(camera_up)),
                                       -dot(path.normal, normalize(camera_forward)));
            }
        }
        sum += path.light;
        seed = path.seed;
    }
    const float scale = 1.0f / float(samples);
    noisy[launch_index] = make_float4(sum * scale, 1.0f);
    albedo_guide[launch_index] = make_float4(albedos * scale, 1.0f);
    normal_guide[launch_index] = make_float4(normals * scale, 0.0f);
}

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(Path, path, rtRayPayload, );
rtDeclareVariable(Shadow, shadow, rtRayPayload, );
rtDeclareVariable(float3, normal, attribute normal, );
rtDeclareVariable(float3, texcoord, attribute texcoord, );

RT_PROGRAM void miss() {
    path.done = 1;
}

// ---- The light ---------------------------------------------------------------------------------

rtDeclareVariable(float3, light_anchor, , );
rtDeclareVariable(float3, light_edge1, , );
rtDeclareVariable(float3, light_edge2, , );
rtDeclareVariable(float3, emission, , );

RT_PROGRAM void hit_light() {
    if (path.sees_light && dot(ray.direction, cross(light_edge1, light_edge2)) < 0.0f)
        path.light += path.weight * emission;
    path.albedo = make_float3(1.0f);
    path.done = 1;
}

static __device__ __forceinline__ float3 directLight(float3 point, float3 n) {
    const float u = random(path.seed), v = random(path.seed);
    const float3 way = light_anchor + u * light_edge1 + v * light_edge2 - point;
    const float3 area = cross(light_edge1, light_edge2);
    const float square = dot(way, way);
    const float3 direction = way / sqrtf(square);
    const float near = dot(n, direction), far = -dot(direction, area);
    if (near <= 0.0f || far <= 0.0f)
        return make_float3(0.0f);
    Shadow result;
    result.blocked = 0;
    const Ray to_light =
        make_Ray(point, direction, kShadowRay, scene_epsilon, sqrtf(square) - scene_epsilon);
    rtTrace(top_object, to_light, result);
    return result.blocked ? make_float3(0.0f) : emission * (near * far / (square * M_PIf));
}

// ---- Surfaces ----------------------------------------------------------------------------------

rtDeclareVariable(float3, albedo, , );
rtDeclareVariable(float, checks, , "fields in each direction; 0: one colour") = 0.0f;

RT_PROGRAM void hit_diffuse() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float3 n = faceforward(world, -ray.direction, world);
    const float3 point = ray.origin + hit_distance * ray.direction;
    const bool is_dark = (int(floorf(texcoord.x * checks)) + int(floorf(texcoord.y * checks))) & 1;
    path.albedo = is_dark ? albedo * 0.35f : albedo;
    path.normal = n;
    path.weight *= path.albedo;
    path.light += path.weight * directLight(point, n);
    path.origin = point;
    const float u = random(path.seed), v = random(path.seed);
    cosine_sample_hemisphere(u, v, path.direction);
    Onb(n).inverse_transform(path.direction);
    path.sees_light = 0;
}
RT_PROGRAM void block_light() {
    shadow.blocked = 1;
    rtTerminateRay();
}
