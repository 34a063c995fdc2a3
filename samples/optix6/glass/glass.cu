// SPDX-License-Identifier: Apache-2.0
// A path tracer for a box with a light, diffuse walls and glass: the payload carries the path from
// hit to hit. Diffuse hits sample the light. Glass blocks these shadow rays; paths through glass
// find the light by chance.
#include "../device6.h"

using namespace optix;

enum RayType { kPathRay, kShadowRay };

struct Path {
    float3 origin, direction; // of the next segment
    float3 weight, light;
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
rtBuffer<float4, 2> picture;

RT_PROGRAM void trace_paths() {
    unsigned seed = hash(launch_index.x + launch_dim.x * launch_index.y);
    float3 sum = make_float3(0.0f);
    for (unsigned i = 0; i < samples; ++i) {
        Path path;
        path.origin = eye;
        const float x = random(seed), y = random(seed);
        path.direction = cameraDirection(x, y);
        path.weight = make_float3(1.0f);
        path.light = make_float3(0.0f);
        path.seed = seed;
        path.sees_light = 1;
        path.done = 0;
        for (unsigned depth = 0; depth < max_depth && !path.done; ++depth) {
            const Ray ray =
                make_Ray(path.origin, path.direction, kPathRay, scene_epsilon, RT_DEFAULT_MAX);
            rtTrace(top_object, ray, path);
            if (depth < 3)
                continue;
            const float survival = fminf(fmaxf(path.weight), 0.95f);
            if (random(path.seed) >= survival)
                break;
            path.weight /= survival;
        }
        sum += path.light;
        seed = path.seed;
    }
    picture[launch_index] = make_float4(sum / float(samples), 1.0f);
}

RT_PROGRAM void show_exception() {
    rtPrintExceptionDetails();
    picture[launch_index] = make_float4(1.0f, 0.0f, 1.0f, 1.0f);
}

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(Path, path, rtRayPayload, );
rtDeclareVariable(Shadow, shadow, rtRayPayload, );
rtDeclareVariable(float3, normal, attribute normal, );

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
    if (result.blocked)
        return make_float3(0.0f);
    return emission * (near * far / (square * M_PIf));
}

// ---- Walls -------------------------------------------------------------------------------------

rtDeclareVariable(float3, albedo, , );

RT_PROGRAM void hit_diffuse() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float3 n = faceforward(world, -ray.direction, world);
    const float3 point = ray.origin + hit_distance * ray.direction;
    path.weight *= albedo;
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

// ---- Glass -------------------------------------------------------------------------------------

rtDeclareVariable(float, index_of_refraction, , );
rtDeclareVariable(float3, extinction, , "the logarithm of what passes a unit of length");

// Reflects or refracts, by the Fresnel equations as the probability.
RT_PROGRAM void hit_glass() {
    const float3 n = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float cosine = -dot(ray.direction, n);
    if (cosine < 0.0f) // the segment lay inside
        path.weight *= expf(extinction * hit_distance);
    path.origin = ray.origin + hit_distance * ray.direction;
    path.sees_light = 1;
    const float eta = cosine > 0.0f ? index_of_refraction : 1.0f / index_of_refraction;
    float3 refracted;
    float reflectance = 1.0f;
    if (refract(refracted, ray.direction, n, index_of_refraction)) {
        const float inner = fabsf(dot(refracted, n)), outer = fabsf(cosine);
        const float parallel = (eta * outer - inner) / (eta * outer + inner);
        const float crossed = (outer - eta * inner) / (outer + eta * inner);
        reflectance = 0.5f * (parallel * parallel + crossed * crossed);
    }
    path.direction =
        random(path.seed) < reflectance ? reflect(ray.direction, n) : normalize(refracted);
}
