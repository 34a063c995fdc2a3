// SPDX-License-Identifier: Apache-2.0
// A selector's visit program chooses the mesh by the distance of the ray's origin. All rays should
// select the same mesh, so shadow rays also use the distance from the eye.
#include "../device6.h"

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

RT_PROGRAM void miss() {
    radiance.color =
        lerp(make_float3(0.9f), make_float3(0.45f, 0.6f, 0.85f), fmaxf(ray.direction.y, 0.0f));
}

// ---- The selector
// --------------------------------------------------------------------------------

rtDeclareVariable(int, levels, , "children of the selector, the finest first");
rtDeclareVariable(float, finest_distance, , "each further level begins at twice the distance");

RT_PROGRAM void visit_level() {
    // The eye in the object space of the selector's children.
    const float3 from = rtTransformPoint(RT_WORLD_TO_OBJECT, eye);
    const int level = int(floorf(log2f(fmaxf(length(from) / finest_distance, 1.0f))));
    rtIntersectChild(unsigned(min(level, levels - 1)));
}

// ---- The mesh
// ------------------------------------------------------------------------------------

rtDeclareVariable(float3, color, , "of the level");
rtDeclareVariable(float3, sun, , );
rtDeclareVariable(float3, normal, attribute normal, );

static __device__ __forceinline__ float sunAt(float3 point, float3 n) {
    const float cosine = dot(n, sun);
    if (cosine <= 0.0f)
        return 0.0f;
    Shadow result;
    result.blocked = 0;
    rtTrace(top_object, make_Ray(point, sun, kShadowRay, scene_epsilon, RT_DEFAULT_MAX), result);
    return result.blocked ? 0.0f : cosine;
}
RT_PROGRAM void hit() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float3 n = faceforward(world, -ray.direction, world);
    const float3 point = ray.origin + hit_distance * ray.direction;
    radiance.color = color * (0.25f + 0.1f * n.y + 0.75f * sunAt(point, n));
}
RT_PROGRAM void block_light() {
    shadow.blocked = 1;
    rtTerminateRay();
}

rtBuffer<float3> vertices;
rtBuffer<uint3> triangles;

// Flat normals, so that the levels are distinguishable.
RT_PROGRAM void triangle_attributes() {
    const uint3 t = triangles[rtGetPrimitiveIndex()];
    normal = cross(vertices[t.y] - vertices[t.x], vertices[t.z] - vertices[t.x]);
}
