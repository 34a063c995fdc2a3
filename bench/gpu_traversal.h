// SPDX-License-Identifier: Apache-2.0
// Shared by bench_gpu_kernels and its kernels.
#pragma once

#include <cstdint>

struct GpuBenchJob {
    uint64_t rays, hits; // bench::Ray; t (-1: no hit) and primitive (any-hit rays: 1)
    uint64_t handle;
    uint64_t counter;       // of rays given out, zero before the launch
    uint32_t count, wanted; // with fewer busy lanes, idle lanes take new rays
};
