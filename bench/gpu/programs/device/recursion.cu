// SPDX-License-Identifier: Apache-2.0
// Closest-hit programs that trace: __closesthit__whitted a shadow ray, the reflected and the
// refracted ray; __closesthit__path a shadow ray and one random ray, however deep.
#include "recursive.h"

extern "C" __global__ void __raygen__camera() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i) {
        const float3 direction = cameraRay(random);
        sum += trace(params.camera.eye, direction, 0.0f, 1, random);
    }
    store(sum / float(params.samples));
}
extern "C" __global__ void __miss__sky() {
    setColor(skyColor(optixGetWorldRayDirection()));
}
extern "C" __global__ void __miss__lamp() {
    optixSetPayload_0(0);
}

DEVICE float3 lampLight(float3 point, float3 normal, unsigned& random) {
    const LampSample lamp = sampleLamp(point, normal, random);
    return maxComponent(lamp.light) > 0.0f && sees(point + normal * params.epsilon, lamp.direction,
                                                   lamp.distance - 2 * params.epsilon, 0.0f)
               ? lamp.light
               : vec(0.0f);
}

extern "C" __global__ void __closesthit__whitted() {
    const Look& m = material();
    bool back;
    const float3 normal = facing(triangleNormal(), back), point = hitPoint();
    const float3 d = optixGetWorldRayDirection(), above = point + normal * params.epsilon;
    const unsigned depth = optixGetPayload_3();
    unsigned random = optixGetPayload_4();
    if (m.surface == kLamp)
        return setColor(params.emission);
    float3 color = m.color * 0.1f;
    if (m.surface == kMatt || m.surface == kGlossy)
        color += m.color * lampLight(point, normal, random);
    if (m.surface != kMatt && depth < params.depth) {
        const float share = m.surface == kMirror ? 0.9f : m.surface == kGlass ? 0.15f : 0.3f;
        color += trace(above, reflect(d, normal), 0.0f, depth + 1, random) * share;
        const float cosine = -dot(normal, d), ratio = back ? 1.4f : 1.0f / 1.4f;
        const float squared = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
        if (m.surface == kGlass && squared > 0.0f)
            color += trace(point - normal * params.epsilon,
                           normalize(d * ratio + normal * (ratio * cosine - sqrtf(squared))), 0.0f,
                           depth + 1, random + 1) *
                     0.85f;
    }
    setColor(color);
}

extern "C" __global__ void __closesthit__path() {
    const Look& m = material();
    bool back;
    const float3 normal = facing(triangleNormal(), back), point = hitPoint();
    const unsigned depth = optixGetPayload_3();
    unsigned random = optixGetPayload_4();
    if (m.surface == kLamp)
        return setColor(depth == 1 ? params.emission : vec(0.0f));
    const Bounce b = bounce(m, optixGetWorldRayDirection(), normal, back, random);
    float3 light = m.surface == kMatt ? lampLight(point, normal, random) : vec(0.0f);
    if (depth < params.depth)
        light += trace(point + normal * (b.passes ? -params.epsilon : params.epsilon), b.direction,
                       0.0f, depth + 1, random);
    setColor(light * b.color);
}
