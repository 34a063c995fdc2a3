// SPDX-License-Identifier: Apache-2.0
// Materials with shadows and reflections: an any-hit program ends shadow rays or tints them, a
// closest-hit program traces the reflected ray.
#include "light.h"

#include "../device6.h"

using namespace optix;

enum RayType { kRadianceRay, kShadowRay };

struct Radiance {
    float3 color;
    float importance; // how much of it reaches the eye
    int depth;
};
struct Shadow {
    float3 passed;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(float, scene_epsilon, , );
rtDeclareVariable(int, max_depth, , );
rtBuffer<Light> lights;
rtBuffer<float4, 2> picture;

// Four rays for each pixel, on a turned grid.
RT_PROGRAM void pinhole_camera() {
    float3 sum = make_float3(0.0f);
    for (int i = 0; i < 4; ++i) {
        const float x = (i % 2) * 0.5f + (i / 2) * 0.25f + 0.125f;
        Radiance result;
        result.importance = 1.0f;
        result.depth = 0;
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
rtDeclareVariable(float3, texcoord, attribute texcoord, );

rtDeclareVariable(float3, horizon_color, , );
rtDeclareVariable(float3, zenith_color, , );
RT_PROGRAM void miss() {
    radiance.color = lerp(horizon_color, zenith_color, fmaxf(ray.direction.y, 0.0f));
}

// ---- Materials ---------------------------------------------------------------------------------

rtDeclareVariable(float3, ambient, , );
rtDeclareVariable(float3, diffuse, , );
rtDeclareVariable(float3, specular, , ) = {0.0f, 0.0f, 0.0f};
rtDeclareVariable(float, exponent, , ) = 40.0f;
rtDeclareVariable(float3, reflectivity, , ) = {0.0f, 0.0f, 0.0f};

static __device__ float3 traceFrom(float3 origin, float3 direction, float3 weight) {
    const float importance = radiance.importance * luminance(weight);
    if (importance < 0.01f || radiance.depth >= max_depth)
        return make_float3(0.0f);
    Radiance next;
    next.importance = importance;
    next.depth = radiance.depth + 1;
    const Ray continued = make_Ray(origin, direction, kRadianceRay, scene_epsilon, RT_DEFAULT_MAX);
    rtTrace(top_object, continued, next);
    return weight * next.color;
}

static __device__ float3 shade(float3 surface) {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float3 n = faceforward(world, -ray.direction, world);
    const float3 point = ray.origin + hit_distance * ray.direction;
    float3 color = ambient * surface;
    for (unsigned i = 0; i < lights.size(); ++i) {
        const Light light = lights[i];
        const float3 way = light.position - point;
        const float distance = length(way);
        const float3 direction = way / distance;
        const float cosine = dot(n, direction);
        if (cosine <= 0.0f)
            continue;
        Shadow result;
        result.passed = make_float3(1.0f);
        const Ray to_light = make_Ray(point, direction, kShadowRay, scene_epsilon, distance);
        rtTrace(top_object, to_light, result);
        const float3 half = normalize(direction - ray.direction);
        const float gloss = powf(fmaxf(dot(n, half), 0.0f), exponent);
        color += result.passed * light.color * (surface * cosine + specular * gloss);
    }
    const float3 fresnel = fresnel_schlick(dot(n, -ray.direction), 5.0f, reflectivity,
                                           make_float3(fmaxf(reflectivity)) * 2.0f);
    return color + traceFrom(point, reflect(ray.direction, n), fresnel);
}

RT_PROGRAM void hit_plain() {
    radiance.color = shade(diffuse);
}

rtDeclareVariable(float3, diffuse2, , "the colour of every other tile");
rtDeclareVariable(float2, tiles, , );
RT_PROGRAM void hit_tiles() {
    const int parity = int(floorf(texcoord.x * tiles.x) + floorf(texcoord.y * tiles.y)) & 1;
    radiance.color = shade(parity ? diffuse2 : diffuse);
}

rtDeclareVariable(float3, tint, , );
RT_PROGRAM void hit_pane() {
    const float3 point = ray.origin + hit_distance * ray.direction;
    radiance.color = traceFrom(point, ray.direction, tint);
}

RT_PROGRAM void block_light() {
    shadow.passed = make_float3(0.0f);
    rtTerminateRay();
}
RT_PROGRAM void tint_light() {
    shadow.passed *= tint;
    rtIgnoreIntersection();
}

// ---- Triangles: the attributes of the other shapes
// -----------------------------------------------

rtBuffer<float3> vertices;
rtBuffer<uint3> triangles;

RT_PROGRAM void triangle_attributes() {
    const uint3 t = triangles[rtGetPrimitiveIndex()];
    normal = normalize(cross(vertices[t.y] - vertices[t.x], vertices[t.z] - vertices[t.x]));
    texcoord = make_float3(rtGetTriangleBarycentrics(), 0.0f);
}
