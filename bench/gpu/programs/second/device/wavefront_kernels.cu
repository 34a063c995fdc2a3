// SPDX-License-Identifier: Apache-2.0
// CUDA kernels of the program wavefront: camera rays, and shading of hits, which appends shadow
// rays and the next rays to queues.
#include "wavefront.h"

#include "sampling.h"

#define DEVICE static __forceinline__ __device__

DEVICE float chance(unsigned& state) {
    const unsigned bits = hashPcg(state);
    state = state * 747796405u + 2891336453u;
    return (bits >> 8) * (1.0f / 16777216.0f);
}

extern "C" __global__ void makeCameraRays(ShadeParams p) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= p.count)
        return;
    QueuedPath path = {vec(1.0f), i, hashPcg(i)};
    const float x = (i % p.width + chance(path.random)) / p.width;
    const float y = (i / p.width + chance(path.random)) / p.height;
    p.nextRays[i] = {p.camera.eye, 0.0f, cameraDirection(p.camera, x, y), 1e16f};
    p.nextPaths[i] = path;
    p.image[i] = make_float4(0.0f, 0.0f, 0.0f, 1.0f);
}

DEVICE float3 sky(float3 d) {
    return lerp(vec(0.95f, 0.9f, 0.85f), vec(0.25f, 0.48f, 0.9f), 0.5f + 0.5f * d.y);
}

extern "C" __global__ void shadeHits(ShadeParams p) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= p.count)
        return;
    const QueuedHit hit = p.hits[i];
    const QueuedRay ray = p.rays[i];
    QueuedPath path = p.paths[i];
    if (hit.t < 0.0f) {
        const float3 light = path.throughput * sky(ray.direction);
        float4 pixel = p.image[path.pixel];
        p.image[path.pixel] =
            make_float4(pixel.x + light.x, pixel.y + light.y, pixel.z + light.z, 1.0f);
        return;
    }
    const uint3 t = p.indices[hit.triangle];
    const float3 a = p.vertices[t.x], b = p.vertices[t.y], c = p.vertices[t.z];
    float3 normal = normalize(cross(b - a, c - a));
    normal = dot(normal, ray.direction) > 0.0f ? -normal : normal;
    const float3 point = a * (1.0f - hit.u - hit.v) + b * hit.u + c * hit.v + normal * 2e-3f;
    path.throughput *= vec(0.75f, 0.7f, 0.6f) * (0.7f + 0.3f * fabsf(normal.y));
    const unsigned chosen = min(unsigned(chance(path.random) * kWaveLamps), kWaveLamps - 1);
    const float4 lamp = p.lamps[chosen];
    const float3 line = vec(lamp.x, lamp.y, lamp.z) - point;
    const float squared = dot(line, line), cosine = dot(normal, line) * rsqrtf(squared);
    if (cosine > 0.0f) {
        const unsigned at = atomicAdd(&p.counters->shadowRays, 1u);
        p.shadowRays[at] = {point, 0.0f, line, 1.0f};
        p.lights[at] = {path.throughput * vec(1.6f, 1.45f, 1.2f) *
                            (kWaveLamps * lamp.w * cosine / (kPi * squared + 1.0f)),
                        path.pixel};
    }
    const float stays = p.bounce < 2 ? 1.0f : fminf(maxComponent(path.throughput) + 0.1f, 1.0f);
    const float u = chance(path.random), v = chance(path.random);
    if (chance(path.random) >= stays)
        return;
    path.throughput = path.throughput / stays;
    const unsigned at = atomicAdd(&p.counters->paths, 1u);
    p.nextRays[at] = {point, 0.0f, cosineDirection(normal, u, v), 1e16f};
    p.nextPaths[at] = path;
}
