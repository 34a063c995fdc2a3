// SPDX-License-Identifier: Apache-2.0
// A cloud in a box: the closest-hit program of the box marches through a three-dimensional texture.
// rtPrintf reports the steps of one launch index, which the host selects.
#include "../device6.h"

using namespace optix;

enum RayType { kRadianceRay };

struct Radiance {
    float3 color;
};

rtDeclareVariable(rtObject, top_object, , );
rtBuffer<float4, 2> picture;

RT_PROGRAM void camera() {
    Radiance result;
    const Ray ray = make_Ray(eye, cameraDirection(0.5f, 0.5f), kRadianceRay, 1e-3f, RT_DEFAULT_MAX);
    rtTrace(top_object, ray, result);
    picture[launch_index] = make_float4(result.color, 1.0f);
}
RT_PROGRAM void show_exception() {
    rtPrintExceptionDetails();
    picture[launch_index] = make_float4(1.0f, 0.0f, 1.0f, 1.0f);
}

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(Radiance, radiance, rtRayPayload, );
rtDeclareVariable(float, leave, attribute leave, "distance at which the ray leaves the box");

static __device__ __forceinline__ float3 sky(float3 d) {
    return lerp(make_float3(0.75f, 0.8f, 0.85f), make_float3(0.15f, 0.3f, 0.6f),
                fmaxf(0.0f, 0.5f + 0.5f * d.y));
}
RT_PROGRAM void miss() {
    radiance.color = sky(ray.direction);
}

// ---- The box
// -------------------------------------------------------------------------------------

rtDeclareVariable(float3, box_low, , );
rtDeclareVariable(float3, box_high, , );

RT_PROGRAM void intersect_box(int) {
    const float3 a = (box_low - ray.origin) / ray.direction;
    const float3 b = (box_high - ray.origin) / ray.direction;
    const float near = fmaxf(fminf(a, b)), far = fminf(fmaxf(a, b));
    if (near < far && rtPotentialIntersection(fmaxf(near, ray.tmin * 1.001f))) {
        leave = far;
        rtReportIntersection(0);
    }
}
RT_PROGRAM void bound_box(int, float result[6]) {
    Aabb* box = (Aabb*)result;
    box->set(box_low, box_high);
}

// ---- The cloud
// -----------------------------------------------------------------------------------

rtDeclareVariable(int, density_texture, , "a three-dimensional texture");
rtDeclareVariable(float, density_scale, , "extinction where the texture is one");
rtDeclareVariable(float, step_length, , );
rtDeclareVariable(float3, sun, , );
rtDeclareVariable(float3, sun_color, , );

static __device__ __forceinline__ float density(float3 point) {
    const float3 p = (point - box_low) / (box_high - box_low);
    return density_scale * rtTex3D<float>(density_texture, p.x, p.y, p.z);
}
// The light of the sun that reaches a point.
static __device__ float sunlight(float3 point) {
    const float step = 2.0f * step_length;
    float depth = 0.0f;
    for (int i = 0; i < 12; ++i)
        depth += density(point + sun * (step * (i + 0.5f))) * step;
    return expf(-depth);
}

RT_PROGRAM void hit_cloud() {
    const float cosine = dot(ray.direction, sun);
    // Light scatters more forwards than backwards (Henyey and Greenstein 1941).
    const float g = 0.35f, base = 1.0f + g * g - 2.0f * g * cosine;
    const float phase = (1.0f - g * g) / (base * sqrtf(base));
    float3 light = make_float3(0.0f);
    float passed = 1.0f;
    int steps = 0;
    rtPrintf("pixel %u %u: from %.3f to %.3f\n", launch_index.x, launch_index.y, hit_distance,
             leave);
    for (float t = hit_distance + 0.5f * step_length; t < leave && passed > 0.01f;
         t += step_length, ++steps) {
        const float3 point = ray.origin + t * ray.direction;
        const float extinction = density(point);
        if (extinction <= 0.0f)
            continue;
        const float share = 1.0f - expf(-extinction * step_length);
        const float lit = sunlight(point);
        light += passed * share * (sun_color * (lit * phase) + make_float3(0.3f, 0.36f, 0.45f));
        passed *= 1.0f - share;
        rtPrintf("  t %.3f extinction %.3f sunlight %.3f passed %.3f\n", t, extinction, lit,
                 passed);
    }
    rtPrintf("  %d steps, light %.3f %.3f %.3f\n", steps, light.x, light.y, light.z);
    radiance.color = light + passed * sky(ray.direction);
}
