// SPDX-License-Identifier: Apache-2.0
// Data that bench_gpu shares with its device programs.
#pragma once

struct GpuRay {
    float ox, oy, oz, tmin;
    float dx, dy, dz, tmax;
};

struct GpuHit {
    float t;                // negative: no hit
    unsigned int primitive; // ~0u: no hit; any-hit rays: 1 occluded, 0 not
    unsigned int instance;  // where there are instances
};

struct GpuRaysParams {
    const GpuRay* rays;
    GpuHit* hits;
    unsigned long long handle;
    const float* spheres; // centre and radius of each custom primitive
    const float* times;   // of each ray, where things move
};
