// SPDX-License-Identifier: Apache-2.0
// The row kernels for SUNSTONE_GUIDES planes of guides: a thread is a row's chunk of one pixel.
// Compiled once for each number of guides, so that a driver compiles only the kernels in use.
#include "denoise/gpu/kernel.h"

using namespace sunstone::denoise;
using namespace sunstone::denoise::gpu;

#define SUNSTONE_ROW_KERNEL(name, chunk)                                                           \
    SUNSTONE_KERNEL name(const __grid_constant__ Job job, uint32_t width, uint32_t height) {       \
        uint32_t x, y;                                                                             \
        if (findPixel(job, width, height, x, y))                                                   \
            chunk(job.pass, y, x, x + 1);                                                          \
    }

SUNSTONE_ROW_KERNEL(sunstone_repair, (repairChunk<SUNSTONE_GUIDES, 1>))
SUNSTONE_ROW_KERNEL(sunstone_residual, (residualChunk<SUNSTONE_GUIDES, 1>))
SUNSTONE_ROW_KERNEL(sunstone_spread, (spreadChunk<SUNSTONE_GUIDES, 1>))
#if SUNSTONE_GUIDES != 0
SUNSTONE_ROW_KERNEL(sunstone_detail, (detailChunk<SUNSTONE_GUIDES, 1>))
#endif
SUNSTONE_ROW_KERNEL(sunstone_smooth, (smoothChunk<SUNSTONE_GUIDES, false, 1>))
SUNSTONE_ROW_KERNEL(sunstone_smooth_alpha, (smoothChunk<SUNSTONE_GUIDES, true, 1>))
