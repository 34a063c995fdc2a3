// SPDX-License-Identifier: Apache-2.0
// The start of a call, the steps other than row kernels, and the statistics.
#include "denoise/gpu/kernel.h"

using namespace sunstone::denoise;
using namespace sunstone::denoise::gpu;

// One thread. Reports a refused call to the host; the entry's number is written last.
SUNSTONE_KERNEL sunstone_begin(CallInputs inputs, Control* control, Report* report,
                               uint64_t stream) {
    const CallFinding finding = examine(inputs, *control);
    if (finding.fault == CallFault::kNone)
        return;
    const uint32_t before = atomicAdd(&report->count, 1u);
    Report::Entry& entry = report->entries[before % Report::kEntries];
    entry.stream = stream;
    entry.inputs = inputs;
    entry.finding = finding;
    __threadfence_system();
    const_cast<volatile uint32_t&>(entry.number) = before + 1;
}

#define SUNSTONE_STEP_KERNEL(name, step, what)                                                     \
    SUNSTONE_KERNEL name(const __grid_constant__ Job job, uint32_t width, uint32_t height) {       \
        uint32_t x, y;                                                                             \
        if (findPixel(job, width, height, x, y))                                                   \
            step(what, x, y);                                                                      \
    }

SUNSTONE_STEP_KERNEL(sunstone_guides, loadGuides, job)
SUNSTONE_STEP_KERNEL(sunstone_alpha, loadAlpha, job)
SUNSTONE_STEP_KERNEL(sunstone_alpha_as_color, alphaAsColor, job)
SUNSTONE_STEP_KERNEL(sunstone_color_as_alpha, colorAsAlpha, job)
SUNSTONE_STEP_KERNEL(sunstone_color, loadColor, job)
#define SUNSTONE_CHUNK_KERNEL(name, chunk)                                                         \
    SUNSTONE_KERNEL name(const __grid_constant__ Job job, uint32_t width, uint32_t height) {       \
        uint32_t x, y;                                                                             \
        if (findPixel(job, width, height, x, y))                                                   \
            chunk(job.pass, y, x, x + 1);                                                          \
    }

SUNSTONE_CHUNK_KERNEL(sunstone_loss, lossChunk<1>)
SUNSTONE_CHUNK_KERNEL(sunstone_correlate, correlateChunk<1>)
SUNSTONE_CHUNK_KERNEL(sunstone_gather, gatherChunk<1>)
SUNSTONE_CHUNK_KERNEL(sunstone_sum_row, sumRowChunk<1>)
SUNSTONE_CHUNK_KERNEL(sunstone_mean_of_box, meanOfBoxChunk<1>)
SUNSTONE_CHUNK_KERNEL(sunstone_return, returnChunk<1>)
SUNSTONE_STEP_KERNEL(sunstone_restore, restoreColor, job)
SUNSTONE_STEP_KERNEL(sunstone_compress, compressPixel, job.upsampler)
SUNSTONE_STEP_KERNEL(sunstone_tensor, tensorPixel, job.upsampler)
SUNSTONE_STEP_KERNEL(sunstone_upsample, upsamplePixel, job.upsampler)
SUNSTONE_STEP_KERNEL(sunstone_blend, blendHistory, job)
SUNSTONE_STEP_KERNEL(sunstone_write, writeColor, job)
SUNSTONE_STEP_KERNEL(sunstone_tone_map, toneMap, job)
SUNSTONE_STEP_KERNEL(sunstone_structure, compareStructure, job)

// Adds up over the block's threads; thread 0 receives the sums.
template <class Logs>
static inline __device__ void addUp(Logs& logs) {
    __shared__ LogSum shared[kTileThreads];
    const uint32_t thread = threadIdx.y * kTileWidth + threadIdx.x;
    for (LogSum& sum : logs.sums) {
        shared[thread] = sum;
        __syncthreads();
        for (uint32_t half = kTileThreads / 2; half != 0; half /= 2) {
            if (thread < half)
                shared[thread].add(shared[thread + half]);
            __syncthreads();
        }
        sum = shared[0];
        __syncthreads();
    }
}

// A single block writes the result; several blocks write their sums, for addBlocks.
template <class Logs>
static inline __device__ void addPixels(const Image& image, LogSum* sums, float* result) {
    Logs logs;
    const uint32_t rows = gridDim.x * kTileHeight;
    for (uint32_t y = blockIdx.x * kTileHeight + threadIdx.y; y < image.height; y += rows)
        for (uint32_t x = threadIdx.x; x < image.width; x += kTileWidth) {
            float channels[4] = {};
            readPixel(image, x, y, channels);
            logs.add(channels);
        }
    addUp(logs);
    if (threadIdx.x + threadIdx.y != 0)
        return;
    if (gridDim.x == 1)
        return logs.result(result);
    for (int i = 0; i < Logs::kSums; ++i)
        sums[blockIdx.x * Logs::kSums + i] = logs.sums[i];
}
template <class Logs>
static inline __device__ void addBlocks(const LogSum* sums, uint32_t count, float* result) {
    Logs logs;
    for (uint32_t block = threadIdx.y * kTileWidth + threadIdx.x; block < count;
         block += kTileThreads)
        for (int i = 0; i < Logs::kSums; ++i)
            logs.sums[i].add(sums[block * Logs::kSums + i]);
    addUp(logs);
    if (threadIdx.x + threadIdx.y == 0)
        logs.result(result);
}

SUNSTONE_KERNEL sunstone_luminance(Image image, LogSum* sums, float* result) {
    addPixels<LuminanceLogs>(image, sums, result);
}
SUNSTONE_KERNEL sunstone_luminance_blocks(const LogSum* sums, uint32_t count, float* result) {
    addBlocks<LuminanceLogs>(sums, count, result);
}
SUNSTONE_KERNEL sunstone_colors(Image image, LogSum* sums, float* result) {
    addPixels<ColorLogs>(image, sums, result);
}
SUNSTONE_KERNEL sunstone_colors_blocks(const LogSum* sums, uint32_t count, float* result) {
    addBlocks<ColorLogs>(sums, count, result);
}
