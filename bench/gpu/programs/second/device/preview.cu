// SPDX-License-Identifier: Apache-2.0
// A progressive path tracer: a launch adds a sample to the mean of each pixel and shows the mean.
// Payload: the address of the path; for shadow rays one word, which a closest-hit program sets.
#include "preview.h"
#include "tools.h"

extern "C" {
__constant__ PreviewParams params;
}

constexpr unsigned kPathRay = 0, kShadowRay = 1, kRayTypes = 2;

// The path's state lives in the ray generation program; hits change it.
class PreviewPath {
public:
    __device__ PreviewPath(float3 from, float3 towards, unsigned state)
        : origin(from), direction(towards), throughput(vec(1.0f)), light(vec(0.0f)), random(state),
          seesLamp(true), isOver(false) {}

    __device__ void trace() {
        const unsigned long long address = reinterpret_cast<unsigned long long>(this);
        unsigned words[2] = {unsigned(address & 0xffffffffull), unsigned(address >> 32)};
        optixTrace(params.room, origin, direction, 1e-4f, 1e16f, 0.0f, OptixVisibilityMask(3),
                   OPTIX_RAY_FLAG_NONE, kPathRay, kRayTypes, kPathRay, words[0], words[1]);
    }
    __device__ static PreviewPath* current() {
        union {
            unsigned words[2];
            PreviewPath* path;
        } payload;
        payload.words[0] = optixGetPayload_0();
        payload.words[1] = optixGetPayload_1();
        return payload.path;
    }
    __device__ float next() { return nextFloat(random); }
    // Ends dim paths in proportion to their weight.
    __device__ bool survives(unsigned bounce) {
        const float chance = bounce < 3 ? 1.0f : fminf(maxComponent(throughput), 0.95f);
        if (next() >= chance)
            return false;
        throughput *= vec(1.0f / chance);
        return true;
    }

    float3 origin, direction, throughput, light;
    unsigned random;
    bool seesLamp; // the next hit counts the light of a lamp
    bool isOver;
};

DEVICE bool isShadowed(float3 from, float3 to) {
    unsigned hit = 0;
    optixTrace(params.room, from, to - from, 1e-4f, 0.9999f, 0.0f, OptixVisibilityMask(3),
               OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT, kShadowRay, kRayTypes, kShadowRay, hit);
    return hit != 0;
}

extern "C" __global__ void __closesthit__block() {
    optixSetPayload_0(1);
}

// Light that arrives at a matt point from one point of the lamp.
DEVICE float3 lampLight(PreviewPath* path, float3 point, float3 normal) {
    const PreviewLamp& lamp = params.lamp;
    const float s = path->next(), t = path->next();
    const float3 on = lamp.corner + lamp.u * s + lamp.v * t, line = on - point;
    const float squared = dot(line, line);
    const float here = dot(normal, line), there = -dot(lamp.normal, line);
    if (here <= 0.0f || there <= 0.0f || isShadowed(point, on))
        return vec(0.0f);
    return lamp.emission * (here * there * lamp.area / (kPi * squared * squared));
}

extern "C" __global__ void __closesthit__surface() {
    PreviewPath* const path = PreviewPath::current();
    const PreviewRecord* const record =
        reinterpret_cast<const PreviewRecord*>(optixGetSbtDataPointer());
    if (maxComponent(record->emission) > 0.0f) {
        if (path->seesLamp)
            path->light += path->throughput * record->emission;
        path->isOver = true;
        return;
    }
    const uint3 corners = record->indices[optixGetPrimitiveIndex()];
    const float3 a = record->vertices[corners.x];
    const float3 normal = towardsRay(
        normalize(cross(record->vertices[corners.y] - a, record->vertices[corners.z] - a)));
    path->origin = rayPoint() + normal * 1e-4f;
    path->throughput *= record->albedo;
    path->seesLamp = path->next() < record->gloss;
    const float s = path->next(), t = path->next();
    const float3 around = cosineDirection(normal, s, t);
    if (path->seesLamp) {
        path->direction = normalize(reflect(path->direction, normal) + around * 0.15f);
        return;
    }
    path->direction = around;
    path->light += path->throughput * lampLight(path, path->origin, normal);
}

extern "C" __global__ void __miss__outside() {
    PreviewPath* const path = PreviewPath::current();
    path->light += path->throughput * vec(0.02f);
    path->isOver = true;
}

extern "C" __global__ void __raygen__sample() {
    const uint3 index = optixGetLaunchIndex();
    const unsigned pixel = index.y * params.width + index.x;
    unsigned random = hashPcg(hashPcg(pixel) ^ params.samplesSoFar);
    const float x = (index.x + nextFloat(random)) / params.width;
    const float y = (index.y + nextFloat(random)) / params.height;
    PreviewPath path(params.camera.eye, cameraDirection(params.camera, x, y), random);
    for (unsigned bounce = 0; bounce < params.maxBounces; ++bounce) {
        path.trace();
        if (path.isOver || !path.survives(bounce))
            break;
    }
    const float4 old = params.mean[pixel];
    const float share = 1.0f / float(params.samplesSoFar + 1);
    const float3 mean = lerp(vec(old.x, old.y, old.z), path.light, share);
    params.mean[pixel] = withWeight(mean, 1.0f);
    const auto byteOf = [](float value) {
        return (unsigned char)(__saturatef(sqrtf(value / (1.0f + value))) * 255.0f);
    };
    params.shown[pixel] = make_uchar4(byteOf(mean.x), byteOf(mean.y), byteOf(mean.z), 255);
}
