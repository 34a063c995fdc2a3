// SPDX-License-Identifier: Apache-2.0
// Device code of ranks_client.cpp: pictures that need every kind of object.
#include <optix_world.h>

using namespace optix;

struct Payload {
    float3 color;
};

rtDeclareVariable(uint2, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint2, launch_dim, rtLaunchDim, );
rtDeclareVariable(unsigned, subframe, rtSubframeIndex, );
rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(int, work, , "more to do for each pixel");
rtBuffer<float4, 2> picture;
rtBuffer<float> weights;
rtDeclareVariable(rtBufferId<float>, more_weights, , );
rtDeclareVariable(rtCallableProgramId<float(float)>, shade, , );
rtDeclareVariable(rtCallableProgramX<float(float)>, bound_shade, , );
rtDeclareVariable(int, other_id, , );
rtDeclareVariable(int, by_id, , );

static __device__ __forceinline__ float random(unsigned& state) {
    state = state * 747796405u + 2891336453u;
    const unsigned word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (((word >> 22u) ^ word) >> 8) * (1.0f / 16777216.0f);
}

RT_PROGRAM void show() {
    unsigned seed = launch_index.x + launch_dim.x * (launch_index.y + launch_dim.y * subframe);
    float3 sum = make_float3(0.0f);
    for (int i = 0; i < work; ++i) {
        Payload p;
        p.color = make_float3(0.0f);
        const float x = (launch_index.x + random(seed)) / launch_dim.x,
                    y = (launch_index.y + random(seed)) / launch_dim.y;
        const Ray down = make_Ray(make_float3(x, y, 10.0f), make_float3(0, 0, -1), 0, 0.0f, 100.0f);
        rtTrace(top_object, down, p);
        sum += p.color * (1.0f / work);
    }
    const float noise = random(seed);
    picture[launch_index] =
        make_float4(sum.x * weights[launch_index.x % weights.size()],
                    sum.y * more_weights[0] + 0.1f * noise, bound_shade(shade(sum.z)), 1.0f);
}

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(Payload, payload, rtRayPayload, );
rtDeclareVariable(float3, color, , );
rtDeclareVariable(float, scale, , );
rtDeclareVariable(float3, tone, attribute tone, );

RT_PROGRAM void missed() {
    payload.color = make_float3(0.1f, 0.2f, 0.3f);
}
RT_PROGRAM void hit() {
    const float4 a = rtTex2D<float4>(other_id, tone.x, tone.y);
    const float4 b = rtTex2D<float4>(by_id, tone.y, tone.x);
    payload.color = color * tone + 0.25f * make_float3(a.x, a.y, b.z);
}
RT_PROGRAM void pass_left() {
    if (rtTransformPoint(RT_OBJECT_TO_WORLD, make_float3(0.0f)).x < -5.0f)
        rtIgnoreIntersection();
}
RT_CALLABLE_PROGRAM float half_of(float value) {
    return 0.5f * value;
}
RT_CALLABLE_PROGRAM float scaled(float value) {
    return scale * value;
}
RT_PROGRAM void corner_tone() {
    const float2 b = rtGetTriangleBarycentrics();
    tone = make_float3(b.x, b.y, 1.0f - b.x - b.y);
}

rtDeclareVariable(float, radius, , );
RT_PROGRAM void disc_bounds(int, float box[6]) {
    box[0] = box[1] = -radius, box[2] = -0.01f;
    box[3] = box[4] = radius, box[5] = 0.01f;
}
RT_PROGRAM void disc_hit(int) {
    const float t = -ray.origin.z / ray.direction.z;
    const float3 p = ray.origin + t * ray.direction;
    if (p.x * p.x + p.y * p.y > radius * radius || !rtPotentialIntersection(t))
        return;
    tone = make_float3(0.5f + 0.5f * p.x / radius, 0.5f + 0.5f * p.y / radius, 0.5f);
    rtReportIntersection(0);
}
rtDeclareVariable(int, chosen, , );
RT_PROGRAM void visit() {
    rtIntersectChild(chosen);
}
