// SPDX-License-Identifier: Apache-2.0
// Queues of rays in device memory, which wavefront.cu traces and wavefront_kernels.cu fills.
#pragma once

#include "camera.h"

#include <optix.h>

struct QueuedRay {
    float3 origin;
    float tmin;
    float3 direction;
    float tmax;
};
struct QueuedHit {
    float t; // negative: none
    float u, v;
    unsigned triangle;
};
struct QueuedPath {
    float3 throughput;
    unsigned pixel;
    unsigned random;
};
struct QueuedLight { // light that arrives if the shadow ray is free
    float3 light;
    unsigned pixel;
};

constexpr unsigned kWaveLamps = 8;

struct WaveCounters {
    unsigned paths, shadowRays;
};

struct WaveParams {
    OptixTraversableHandle handle;
    const QueuedRay* rays;
    QueuedHit* hits;
    const QueuedRay* shadowRays;
    const QueuedLight* lights;
    float4* image;
};

struct ShadeParams {
    const QueuedRay* rays;
    const QueuedHit* hits;
    const QueuedPath* paths;
    QueuedRay* nextRays;
    QueuedPath* nextPaths;
    QueuedRay* shadowRays;
    QueuedLight* lights;
    WaveCounters* counters; // of the next queues
    float4* image;
    const float3* vertices;
    const uint3* indices;
    Camera camera;
    float4 lamps[kWaveLamps]; // place and power
    unsigned count;           // of paths
    unsigned width, height;
    unsigned bounce;
};
