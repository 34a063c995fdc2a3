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
};
