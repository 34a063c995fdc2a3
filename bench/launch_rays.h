// SPDX-License-Identifier: Apache-2.0
// Data that bench_launch shares with its device programs.
#pragma once

struct BenchRay {
    float ox, oy, oz, tmin;
    float dx, dy, dz, tmax;
};

struct BenchHit {
    float t;                // negative: no hit
    unsigned int primitive; // ~0u: no hit; any-hit rays: 1 occluded, 0 not
};

struct LaunchRaysParams {
    const BenchRay* rays;
    BenchHit* hits;
    unsigned long long handle;
    float shutter; // 1: each ray has its own time, 0: all have time 0
};

#ifdef __CUDACC__
__device__
#endif
inline float timeOfRay(unsigned int ray) {
    return float(ray * 2654435761u >> 8) * 0x1p-24f;
}
