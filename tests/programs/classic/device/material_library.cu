// SPDX-License-Identifier: Apache-2.0
#include "material_library.h"

#include <optix_world.h>

using namespace optix;

struct PerRayData {
    float4 value;
    int hops;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(unsigned int, columns, , ) = 1u;
rtDeclareVariable(uint2, pixel, rtLaunchIndex, );
rtDeclareVariable(optix::Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(PerRayData, prd, rtPayload, );
rtBuffer<float4, 2> output;

// ---- what materials and instances override
rtDeclareVariable(float3, base_color, , ) = {0.25f, 0.5f, 0.75f};
rtDeclareVariable(float, roughness, , ) = 0.125f;
rtDeclareVariable(int, layer, , ) = -3;
rtDeclareVariable(uint2, tile, , );
rtDeclareVariable(Matrix3x3, tint, , );
rtDeclareVariable(Swatch, swatch, , );
rtDeclareVariable(unsigned int, light_index, , ) = 0;
rtBuffer<Light> lights;
rtBuffer<rtBufferId<float, 1>, 1> curves;
rtBuffer<rtCallableProgramId<float(float, float)>, 1> mixers;
typedef rtCallableProgramX<float3(float3, int)> Pattern;
rtDeclareVariable(Pattern, pattern, , );

// ---- patterns and mixers
rtDeclareVariable(float, pattern_scale, , );

RT_CALLABLE_PROGRAM float3 plain_pattern(float3 color, int) {
    return pattern_scale * color;
}
RT_CALLABLE_PROGRAM float3 striped_pattern(float3 color, int i) {
    return i & 1 ? pattern_scale * color : make_float3(color.z, color.y, color.x);
}
RT_CALLABLE_PROGRAM float mix_linear(float a, float b) {
    return a + b;
}
RT_CALLABLE_PROGRAM float mix_square(float a, float b) {
    return a * a + b;
}
RT_CALLABLE_PROGRAM float mix_chain(float a, float b) { // calls another one of the table
    return mixers[0](a, b) * mixers[1](a, b);
}

// ---- one unit square for each material, side by side
rtDeclareVariable(float2, corner, , );
rtDeclareVariable(float2, texcoord, attribute texcoord, );
rtDeclareVariable(int, which, attribute which, );

RT_PROGRAM void square_bounds(int, float result[6]) {
    Aabb* box = (Aabb*)result;
    box->m_min = make_float3(corner.x, corner.y, 0);
    box->m_max = make_float3(corner.x + 1, corner.y + 1, 0);
}
RT_PROGRAM void square_intersect(int primitive) {
    const float t = -ray.origin.z / ray.direction.z;
    const float2 at = make_float2(ray.origin) + t * make_float2(ray.direction) - corner;
    if (at.x < 0 || at.x >= 1 || at.y < 0 || at.y >= 1 || !rtPotentialIntersection(t))
        return;
    texcoord = at;
    which = primitive;
    rtReportIntersection(at.x < 0.5f ? 0 : 1);
}

// ---- programs that all materials share
static __device__ float4 shade() {
    const Light& light = lights[light_index];
    rtBufferId<float, 1> curve(light.curve);
    float sum = 0;
    for (unsigned i = 0; i < light.count; ++i)
        sum += curve[i];
    for (int i = 0; i < 2; ++i)
        sum = rtCallableProgramId<float(float, float)>(light.falloff[i])(sum, light.weight);
    const float3 color = tint * pattern(base_color, layer);
    return make_float4(color * sum + make_float3(tile.x, tile.y, roughness),
                       swatch.rgba[1] + swatch.gloss + swatch.flags[2] + curves[layer & 1][0]);
}
RT_PROGRAM void shade_front() {
    prd.value = shade();
}
RT_PROGRAM void shade_back() {
    prd.value = -1.0f * shade();
    prd.hops = which;
}
RT_PROGRAM void no_hit() {
    prd.value = make_float4(-7);
}

RT_PROGRAM void look_at_all() {
    PerRayData p;
    p.hops = 0;
    const optix::Ray down = make_Ray(make_float3(0.5f * pixel.x + 0.25f, pixel.y + 0.5f, 1),
                                     make_float3(0, 0, -1), 0, 0.0f, RT_DEFAULT_MAX);
    rtTrace(top_object, down, p);
    output[pixel] = p.value;
}
