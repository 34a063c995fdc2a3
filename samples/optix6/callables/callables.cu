// SPDX-License-Identifier: Apache-2.0
// Materials of callable programs. hit_surface() is independent of materials: it calls the program
// that the material binds (`bsdf`), which reads variables of its own, and the pattern whose id the
// instance sets. Lights are ids in a buffer.
#include "bsdf.h"

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
rtDeclareVariable(unsigned, samples, , );
rtDeclareVariable(unsigned, max_depth, , );
rtBuffer<float4, 2> picture;

// The sky by the direction.
rtDeclareVariable(rtCallableProgramX<float3(float3)>, sky, , );

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

RT_PROGRAM void show_exception() {
    rtPrintExceptionDetails();
    picture[launch_index] = make_float4(1.0f, 0.0f, 1.0f, 1.0f);
}

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(Path, path, rtRayPayload, );
rtDeclareVariable(Shadow, shadow, rtRayPayload, );
rtDeclareVariable(float3, normal, attribute normal, );
rtDeclareVariable(float3, texcoord, attribute texcoord, );

RT_PROGRAM void miss() {
    path.light += path.weight * sky(ray.direction);
    path.done = 1;
}

// ---- The one closest-hit program
// -----------------------------------------------------------------

// From the directions in the surface's frame (z is the normal): the scattered one and its weight.
rtDeclareVariable(rtCallableProgramX<BsdfSample(float3, float3, float2)>, bsdf, , );
rtDeclareVariable(rtCallableProgramId<float3(float3)>, pattern, , "colour by texture coordinates");
// Each: from a point to a sample of a light, two random numbers given.
rtBuffer<rtCallableProgramId<LightSample(float3, float2)>> light_programs;

static __device__ __forceinline__ float2 random2(unsigned& seed) {
    const float u = random(seed);
    return make_float2(u, random(seed));
}

RT_PROGRAM void hit_surface() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float3 n = faceforward(world, -ray.direction, world);
    const float3 point = ray.origin + hit_distance * ray.direction;
    const Onb frame(n);
    const float3 to_eye =
        make_float3(-dot(ray.direction, frame.m_tangent), -dot(ray.direction, frame.m_binormal),
                    -dot(ray.direction, frame.m_normal));
    const float3 color = pattern(texcoord);
    const BsdfSample next = bsdf(to_eye, color, random2(path.seed));

    // Lights without extent or of small extent illuminate only the diffuse share.
    for (unsigned i = 0; i < light_programs.size(); ++i) {
        const LightSample light = light_programs[i](point, random2(path.seed));
        const float cosine = dot(n, light.direction);
        if (cosine <= 0.0f || next.diffuse <= 0.0f)
            continue;
        Shadow result;
        result.blocked = 0;
        const Ray to_light = make_Ray(point, light.direction, kShadowRay, scene_epsilon,
                                      light.distance - scene_epsilon);
        rtTrace(top_object, to_light, result);
        if (!result.blocked)
            path.light += path.weight * color * light.radiance * (next.diffuse * cosine);
    }
    path.weight *= next.weight;
    path.origin = point;
    path.direction = next.direction;
    frame.inverse_transform(path.direction);
    if (fmaxf(path.weight) < 0.005f)
        path.done = 1;
}

RT_PROGRAM void block_light() {
    shadow.blocked = 1;
    rtTerminateRay();
}
