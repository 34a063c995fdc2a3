// SPDX-License-Identifier: Apache-2.0
// Programs of fuzz_api6 beside those of tests/api6/programs.cu: rays that programs of hits trace,
// boxes of all kinds, motion, children that may not exist. Variables have the names of the others.
#include <optix_world.h>

using namespace optix;

struct Payload {
    float value;
    int calls;
    float3 normal;
    float large[40];
};
rtDeclareVariable(uint3, launch_index, rtLaunchIndex, );
rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(Payload, payload, rtRayPayload, );
rtDeclareVariable(float, current_time, rtCurrentTime, );
rtDeclareVariable(float, height, , ) = 1.0f;
rtDeclareVariable(int, chosen, , ) = 0;
rtDeclareVariable(float4, tag, attribute tag, ); // a float in the other text
rtBuffer<float, 1> result;
rtBuffer<float4, 2> picture;

RT_PROGRAM void shoot_far() {
    Payload p;
    p.calls = 0;
    p.value = 0;
    const float3 origin = make_float3(0.1f * launch_index.x, 0.1f * launch_index.y, height);
    const Ray down = make_Ray(origin, make_float3(0.01f, 0, -1), chosen, 0.0f, RT_DEFAULT_MAX);
    rtTrace(top_object, down, 0.25f * launch_index.z, p);
    picture[make_uint2(launch_index.x, launch_index.y)] = make_float4(p.value);
    result[launch_index.x] = float(p.calls);
}
RT_PROGRAM void hit_again() {
    if (++payload.calls < 4)
        rtTrace(top_object, ray, payload);
    payload.value += tag.w;
}
RT_PROGRAM void any_random() {
    const unsigned number = (rtGetPrimitiveIndex() * 747796405u + __float_as_uint(ray.tmax)) >> 7;
    if (number % 3 == 0)
        rtIgnoreIntersection();
    if (number % 5 == 0)
        rtTerminateRay();
    if (number % 11 == 0)
        rtThrow(RT_EXCEPTION_USER + number % 16);
    tag = make_float4(payload.value);
}
RT_PROGRAM void bound_any(int primitive, float box[6]) {
    const float values[8] = {0, 1, -1, 1e30f, -1e30f, __int_as_float(0x7fffffff), 1e-40f, height};
    for (int i = 0; i < 6; ++i)
        box[i] = values[(primitive * 7 + i * 3) & 7];
}
RT_PROGRAM void bound_motion(int primitive, int step, float box[6]) {
    for (int i = 0; i < 6; ++i)
        box[i] = float(i / 3) + 0.5f * step + primitive;
}
RT_PROGRAM void intersect_all(int primitive) {
    for (int i = 0; i < 3; ++i)
        if (rtPotentialIntersection(1.0f + primitive - 0.25f * i)) {
            tag = make_float4(current_time, float(i), 0, 1);
            rtReportIntersection(unsigned(i) * chosen);
        }
}
RT_PROGRAM void visit_many() {
    for (int i = 0; i < 4; ++i)
        rtIntersectChild(unsigned(i * chosen));
}
RT_CALLABLE_PROGRAM float trace_value(float a) {
    Payload p;
    p.calls = 100;
    p.value = a;
    rtTrace(top_object, make_Ray(make_float3(a), make_float3(0, 0, -1), 0, 0.0f, 10.0f), p);
    return p.value;
}
