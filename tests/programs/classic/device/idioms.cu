// SPDX-License-Identifier: Apache-2.0
#include <optix.h>
#include <optix_math.h>
#include <optixu/optixu_aabb_namespace.h>
#include <optixu/optixu_math_namespace.h>
#include <optixu/optixu_matrix_namespace.h>

using namespace optix;

// Many old programs turn this on to see how long pixels take.
#define TIME_VIEW

struct Surface {
    float3 albedo;
    float ior;
    Surface* next; // a pointer of the device
};
struct PerRayData {
    float3 radiance;
    float3 attenuation;
    unsigned int seed;
    int depth;
    double weight;
    float history[24];
    bool done;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(uint3, launch_index, rtLaunchIndex, );
rtDeclareVariable(uint3, launch_dim, rtLaunchDim, );
rtDeclareVariable(unsigned int, launch_x, rtLaunchIndex, );
rtDeclareVariable(optix::Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, t_hit, rtIntersectionDistance, );
rtDeclareVariable(PerRayData, prd, rtPayload, );
rtBuffer<float4, 2> output_buffer;
rtBuffer<unsigned int, 3> counters;
rtBuffer<float, 1> steps;
rtDeclareVariable(unsigned long long, surfaces, , );
rtDeclareVariable(Matrix4x4, view, , );
rtDeclareVariable(double, exposure, , );

// A table that the module has for itself, and memory that launches share.
__constant__ float weights[5] = {0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f};
__device__ unsigned int launches_seen[4];
__device__ float identity_of(float x) {
    return x;
}
__device__ __constant__ char digits[] = "0123456789";

template <int N>
static __host__ __device__ __inline__ unsigned int tea(unsigned int a, unsigned int b) {
    unsigned int sum = 0;
#pragma unroll
    for (int i = 0; i < N; ++i) {
        sum += 0x9e3779b9;
        a += ((b << 4) + 0xa341316c) ^ (b + sum) ^ ((b >> 5) + 0xc8013ea4);
        b += ((a << 4) + 0xad90777d) ^ (a + sum) ^ ((a >> 5) + 0x7e95761e);
    }
    return a;
}
static __device__ __forceinline__ float rnd(unsigned int& previous) {
    previous = previous * 1664525u + 1013904223u;
    return float(previous & 0x00FFFFFF) / float(0x01000000);
}

RT_PROGRAM void camera() {
#ifdef TIME_VIEW
    const clock_t t0 = clock();
#endif
    const size_t2 screen = output_buffer.size();
    const float2 d = make_float2(launch_index.x + 0.5f, launch_index.y + 0.5f) /
                         make_float2(screen.x, screen.y) * 2.f -
                     make_float2(1.f);
    const float4 eye = view * make_float4(d.x, d.y, 0, 1), way = view * make_float4(0, 0, -1, 0);
    PerRayData data;
    data.radiance = make_float3(0);
    data.attenuation = make_float3(1);
    data.seed = tea<16>(launch_index.y * launch_dim.x + launch_index.x, 7);
    data.depth = 0;
    data.weight = 1;
    data.done = false;
    for (int i = 0; i < 24; ++i)
        data.history[i] = -1;
    optix::Ray next(make_float3(eye), normalize(make_float3(way)), 0, 1e-3f);
    while (!data.done && data.depth < 6) {
        rtTrace(top_object, next, data);
        data.history[data.depth * 4] = length(data.radiance);
        ++data.depth;
        next.origin += make_float3(0, 0, -2);
        next.tmin = RT_DEFAULT_MAX > 1e20f ? 1e-4f : 0;
    }
    float sum = 0;
    for (int i = 0; i < 5; ++i)
        sum += weights[i] * data.history[4 * i] + identity_of(data.history[4 * i + 1]);
    output_buffer[make_uint2(launch_index)] =
        make_float4(data.radiance * float(exposure * data.weight), sum);
    atomicAdd(&counters[make_uint3(data.depth, launch_index.y & 1, digits[7] - '7')], 1u);
    if (launch_x == 0 && launch_index.y == 0)
        launches_seen[0] += 1;
#ifdef TIME_VIEW
    const clock_t t1 = clock();
    if (t1 < t0)
        output_buffer[make_uint2(launch_index)].w = -1e9f;
#endif
}

RT_PROGRAM void show_memory() {
    steps[launch_x] = launches_seen[launch_x & 3] + float(steps.size());
}

// ---- a staircase of planes, with the surfaces in a list of the device
rtDeclareVariable(float3, geometric_normal, attribute geometric_normal, );
rtDeclareVariable(int, stair, attribute stair number, );

static __device__ bool intersect_plane(float height, float& t) {
    t = (height - ray.origin.z) / ray.direction.z;
    return t > ray.tmin && t < ray.tmax;
}
RT_PROGRAM void stairs(int primIdx) {
    float t;
    if (!intersect_plane(-2.0f * primIdx, t))
        return;
    if (rtPotentialIntersection(t)) {
        geometric_normal = make_float3(0, 0, ray.direction.z < 0 ? 1 : -1);
        stair = primIdx;
        rtReportIntersection(0);
    }
}
RT_PROGRAM void stairs_bounds(int primIdx, float result[6]) {
    optix::Aabb* aabb = (optix::Aabb*)result;
    aabb->invalidate();
    aabb->include(make_float3(-10, -10, -2.0f * primIdx));
    aabb->include(make_float3(10, 10, -2.0f * primIdx));
}
RT_PROGRAM void climb() {
    const Surface* surface = (const Surface*)surfaces;
    for (int i = 0; i < stair; ++i)
        surface = surface->next;
    const float3 n = faceforward(geometric_normal, -ray.direction, geometric_normal);
    optix::Onb onb(n);
    float3 p = make_float3(0, 0, 1);
    onb.inverse_transform(p);
    const float chance = rnd(prd.seed);
    float3 refracted;
    refract(refracted, ray.direction, n, surface->ior);
    switch (stair % 3) {
    case 0:
        prd.radiance += prd.attenuation * surface->albedo * p.z;
        break;
    case 1:
        prd.attenuation *= lerp(surface->albedo, make_float3(1), 0.5f);
        break;
    default:
        prd.radiance = fmaxf(prd.radiance, surface->albedo) * -refracted.z;
    }
    prd.weight *= 0.5;
    prd.history[prd.depth * 4 + 1] = t_hit + (chance < 0 ? 1 : 0);
    if (stair == 3)
        prd.done = true;
}
RT_PROGRAM void outside() {
    prd.done = true;
    rtThrow(RT_EXCEPTION_USER + 5);
}
RT_PROGRAM void exception() {
    const unsigned int code = rtGetExceptionCode();
    output_buffer[make_uint2(launch_index)] = make_float4(code - RT_EXCEPTION_USER);
    rtPrintExceptionDetails();
}
