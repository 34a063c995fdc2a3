// SPDX-License-Identifier: Apache-2.0
// Programs with few rays: a G-buffer, ambient occlusion, direct light with soft shadows (with
// random times if MOVES is set), tiles of a picture, and a launch that keeps few of its results.
#include "common.h"

#if MOVES
#define TIME(random) nextFloat(random)
#else
#define TIME(random) 0.0f
#endif

struct Hit {
    float3 normal;
    float distance; // negative: none
    float3 color;
};
DEVICE Hit firstHit(float3 origin, float3 direction, float time) {
    unsigned x = 0, y = 0, z = 0, t = 0, r = 0, g = 0, b = 0;
    optixTrace(params.scene, origin, direction, 0.0f, 1e16f, time, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT, 0, 1, 0, x, y, z, t, r, g, b);
    return {asFloats(x, y, z), __uint_as_float(t), asFloats(r, g, b)};
}
DEVICE bool isFree(float3 origin, float3 direction, float distance, float time) {
    unsigned hidden = 1, no = 0;
    optixTrace(params.scene, origin, direction, 0.0f, distance, time, OptixVisibilityMask(255),
               OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT |
                   OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT,
               0, 1, 1, hidden, no, no, no, no, no, no);
    return hidden == 0;
}

extern "C" __global__ void __closesthit__surface() {
    bool back;
#if MOVES
    // For a mesh with moving vertices, the normal at the first key suffices.
#endif
    const float3 own = triangleNormal();
#if INSTANCES
    const float3 normal = facing(normalize(optixTransformNormalFromObjectToWorldSpace(own)), back);
    const unsigned seed = hashPcg(optixGetInstanceId());
    const float3 color = vec(0.3f + 0.5f * (seed & 255) / 255.0f, 0.4f, 0.7f);
#else
    const float3 normal = facing(own, back);
    const float3 color = material().color;
#endif
    optixSetPayload_0(__float_as_uint(normal.x));
    optixSetPayload_1(__float_as_uint(normal.y));
    optixSetPayload_2(__float_as_uint(normal.z));
    optixSetPayload_3(__float_as_uint(optixGetRayTmax()));
    optixSetPayload_4(__float_as_uint(color.x));
    optixSetPayload_5(__float_as_uint(color.y));
    optixSetPayload_6(__float_as_uint(color.z));
}
extern "C" __global__ void __miss__sky() {
    optixSetPayload_3(__float_as_uint(-1.0f));
}
extern "C" __global__ void __miss__free() {
    optixSetPayload_0(0);
}

extern "C" __global__ void __raygen__gbuffer() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const float3 direction =
        cameraDirection(params.camera, (index.x + 0.5f) / size.x, (index.y + 0.5f) / size.y);
    const Hit hit = firstHit(params.camera.eye, direction, 0.0f);
    const bool isHit = hit.distance >= 0.0f;
    store(isHit ? hit.normal : vec(0.0f), hit.distance);
    const float3 color = isHit ? hit.color : skyColor(direction);
    params.extra[pixelIndex()] = make_float4(color.x, color.y, color.z, 1.0f);
}

// Light of the sun and of the sky at a point; the sky by one short ray.
DEVICE float3 directLight(const Hit& hit, float3 point, float time, unsigned& random) {
    const float3 above = point + hit.normal * params.epsilon;
    const float cosine = dot(hit.normal, params.light[0]);
    float3 light = vec(0.0f);
    if (cosine > 0.0f && isFree(above, params.light[0], 1e16f, time))
        light = params.emission * cosine;
    const float u = nextFloat(random), v = nextFloat(random);
    if (isFree(above, cosineDirection(hit.normal, u, v), params.reach, time))
        light += skyColor(hit.normal) * 0.5f;
    return hit.color * light;
}

DEVICE float3 directSample(float3 direction, unsigned& random) {
    const float time = TIME(random);
    const Hit hit = firstHit(params.camera.eye, direction, time);
    return hit.distance < 0.0f
               ? skyColor(direction)
               : directLight(hit, params.camera.eye + direction * hit.distance, time, random);
}

extern "C" __global__ void __raygen__direct() {
    float3 sum = vec(0.0f);
    unsigned random = hashPcg(pixelIndex());
    for (unsigned i = 0; i < params.samples; ++i)
        sum += directSample(cameraRay(random), random);
    store(sum / float(params.samples));
}

extern "C" __global__ void __raygen__occlusion() {
    unsigned random = hashPcg(pixelIndex());
    const float3 direction = cameraRay(random);
    const Hit hit = firstHit(params.camera.eye, direction, 0.0f);
    if (hit.distance < 0.0f)
        return store(skyColor(direction));
    const float3 above = params.camera.eye + direction * hit.distance + hit.normal * params.epsilon;
    unsigned open = 0;
    for (unsigned i = 0; i < params.samples; ++i) {
        const float u = nextFloat(random), v = nextFloat(random);
        open += isFree(above, cosineDirection(hit.normal, u, v), params.reach, 0.0f);
    }
    store(vec(float(open) / float(params.samples)));
}

// A tile of the picture.
extern "C" __global__ void __raygen__tile() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const unsigned across = params.width / size.x;
    const unsigned x = params.tile % across * size.x + index.x;
    const unsigned y = params.tile / across * size.y + index.y;
    if (y >= params.height)
        return;
    unsigned random = hashPcg(y * params.width + x);
    const float3 direction =
        cameraDirection(params.camera, (x + 0.5f) / params.width, (y + 0.5f) / params.height);
    const float3 color = directSample(direction, random);
    params.image[y * params.width + x] = make_float4(color.x, color.y, color.z, 1.0f);
}

// There are far more launch indices than pixels; in each square, one index stores its result.
extern "C" __global__ void __raygen__sparse() {
    const uint3 index = optixGetLaunchIndex(), size = optixGetLaunchDimensions();
    const float3 direction =
        cameraDirection(params.camera, (index.x + 0.5f) / size.x, (index.y + 0.5f) / size.y);
    const Hit hit = firstHit(params.camera.eye, direction, 0.0f);
    const unsigned step = size.x / params.width;
    if (index.x % step == 0 && index.y % step == 0)
        params.image[index.y / step * params.width + index.x / step] =
            make_float4(hit.normal.x, hit.normal.y, hit.normal.z, hit.distance);
}
