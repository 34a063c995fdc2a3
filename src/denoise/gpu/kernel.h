// SPDX-License-Identifier: Apache-2.0
// Shared by the files of kernels. The bodies are those of the CPU, compiled as device code.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#pragma clang force_cuda_host_device begin
#include "denoise/gpu/launch.h"
#include "denoise/rows/rows_body.h"
#include "denoise/steps.h"
#pragma clang force_cuda_host_device end

namespace sunstone::denoise::gpu {

#define SUNSTONE_KERNEL extern "C" __global__ void __launch_bounds__(kTileThreads)

// The thread's pixel; false if it has none, or the call is refused.
static inline __device__ bool findPixel(const Job& job, uint32_t width, uint32_t height,
                                        uint32_t& x, uint32_t& y) {
    const uint32_t across = tilesAcross(width);
    x = blockIdx.x % across * kTileWidth + threadIdx.x;
    y = blockIdx.x / across * kTileHeight + threadIdx.y;
    return x < width && y < height && job.control->isRefused == 0;
}

} // namespace sunstone::denoise::gpu
