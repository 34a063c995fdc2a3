// SPDX-License-Identifier: Apache-2.0
// A diffuse path tracer as programs of the classic API: triangles are custom primitives, with a
// bounding box and an intersection program; materials have a closest-hit program for paths and an
// any-hit program for shadow rays.
#include <optix_world.h>

using namespace optix;

enum RayType { kPathRay, kShadowRay };

struct PathPayload {
    float3 origin, direction; // of the path's next segment
    float3 weight, light;
    unsigned seed;
    int done;
};
struct ShadowPayload {
    int blocked;
};

// ---- ray generation ---------------------------------------------------------------------------

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(float3, eye, , );
rtDeclareVariable(float3, camera_forward, , );
rtDeclareVariable(float3, camera_right, , );
rtDeclareVariable(float3, camera_up, , );
rtDeclareVariable(float, scene_epsilon, , );
rtDeclareVariable(unsigned int, samples, , );
rtDeclareVariable(unsigned int, max_depth, , );
rtBuffer<float4, 2> picture;

// A hash whose bits are all usable (O'Neill 2014).
static __device__ __forceinline__ unsigned hash(unsigned value) {
    const unsigned state = value * 747796405u + 2891336453u;
    const unsigned word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
static __device__ __forceinline__ float random(unsigned& seed) {
    seed = hash(seed);
    return (seed >> 8) * (1.0f / 16777216.0f);
}

RT_PROGRAM void trace_paths() {
    unsigned seed = hash(launch_index.x + launch_dim.x * launch_index.y);
    float3 sum = make_float3(0.0f);
    for (unsigned i = 0; i < samples; ++i) {
        const float x = (launch_index.x + random(seed)) / launch_dim.x * 2.0f - 1.0f;
        const float y = 1.0f - (launch_index.y + random(seed)) / launch_dim.y * 2.0f;
        PathPayload path;
        path.origin = eye;
        path.direction = normalize(camera_forward + camera_right * x + camera_up * y);
        path.weight = make_float3(1.0f);
        path.light = make_float3(0.0f);
        path.seed = seed;
        path.done = 0;
        for (unsigned depth = 0; depth < max_depth && !path.done; ++depth) {
            const Ray ray =
                make_Ray(path.origin, path.direction, kPathRay, scene_epsilon, RT_DEFAULT_MAX);
            rtTrace(top_object, ray, path);
        }
        sum += path.light;
        seed = path.seed;
    }
    picture[launch_index] = make_float4(sum / float(samples), 1.0f);
}

// An index that ends with an exception is magenta.
RT_PROGRAM void show_exception() {
    rtPrintExceptionDetails();
    picture[launch_index] = make_float4(1.0f, 0.0f, 1.0f, 1.0f);
}

// ---- rays that hit nothing --------------------------------------------------------------------

rtDeclareVariable(PathPayload, path, rtRayPayload, );
rtDeclareVariable(ShadowPayload, shadow, rtRayPayload, );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(float3, sky_color, , );
rtDeclareVariable(float3, sun_direction, , );
rtDeclareVariable(float3, sun_color, , );

RT_PROGRAM void miss_path() {
    const float blend = 0.5f + 0.5f * ray.direction.y;
    path.light += path.weight * lerp(make_float3(0.9f), sky_color, blend);
    path.done = 1;
}

// ---- materials --------------------------------------------------------------------------------

rtDeclareVariable(float3, shading_normal, attribute shading_normal, );
rtDeclareVariable(float3, albedo, , );

RT_PROGRAM void hit_path() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, shading_normal));
    const float3 normal = faceforward(world, -ray.direction, world);
    const float3 point = ray.origin + hit_distance * ray.direction;
    path.weight *= albedo;

    const float cosine = dot(normal, sun_direction);
    if (cosine > 0.0f) {
        ShadowPayload payload;
        payload.blocked = 0;
        const Ray to_sun =
            make_Ray(point, sun_direction, kShadowRay, scene_epsilon, RT_DEFAULT_MAX);
        rtTrace(top_object, to_sun, payload);
        if (!payload.blocked)
            path.light += path.weight * sun_color * cosine;
    }
    const float u = random(path.seed), v = random(path.seed);
    path.origin = point;
    cosine_sample_hemisphere(u, v, path.direction);
    Onb(normal).inverse_transform(path.direction);
}

RT_PROGRAM void block_light() {
    shadow.blocked = 1;
    rtTerminateRay();
}

// ---- triangles --------------------------------------------------------------------------------

rtBuffer<float3> vertices;
rtBuffer<float3> normals;
rtBuffer<uint3> triangles;

RT_PROGRAM void intersect_mesh(int primitive) {
    const uint3 t = triangles[primitive];
    float3 n;
    float distance, beta, gamma;
    if (!intersect_triangle(ray, vertices[t.x], vertices[t.y], vertices[t.z], n, distance, beta,
                            gamma))
        return;
    if (rtPotentialIntersection(distance)) {
        shading_normal = normalize(normals[t.x] * (1.0f - beta - gamma) + normals[t.y] * beta +
                                   normals[t.z] * gamma);
        rtReportIntersection(0);
    }
}

RT_PROGRAM void bound_mesh(int primitive, float result[6]) {
    const uint3 t = triangles[primitive];
    Aabb* box = (Aabb*)result;
    box->invalidate();
    box->include(vertices[t.x]);
    box->include(vertices[t.y]);
    box->include(vertices[t.z]);
}
