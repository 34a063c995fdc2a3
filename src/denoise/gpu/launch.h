// SPDX-License-Identifier: Apache-2.0
// Definitions shared by the host and the kernels of a GPU's denoiser.
#pragma once

#include "denoise/call.h"
#include "denoise/statistics.h"

namespace sunstone::denoise::gpu {

// Each block of threads has a tile of pixels; tiles are numbered row by row.
constexpr uint32_t kTileWidth = 32, kTileHeight = 8;
constexpr uint32_t kTileThreads = kTileWidth * kTileHeight;

constexpr uint32_t tilesAcross(uint32_t width) {
    return (width + kTileWidth - 1) / kTileWidth;
}
constexpr uint32_t tilesDown(uint32_t height) {
    return (height + kTileHeight - 1) / kTileHeight;
}

// The most blocks of a statistics kernel: each writes its sums, and a last block adds them up. For
// images with fewer pixels the caller's memory may be too small for sums; there is one block then.
constexpr uint32_t kMostLogBlocks = 512;
constexpr uint32_t kPixelsForBlocks = 8192;

// In host memory that kernels write: a ring of refused calls.
struct Report {
    struct Entry {
        uint64_t stream;
        CallInputs inputs;
        CallFinding finding;
        uint32_t number; // counted from 1; written last
    };
    static constexpr uint32_t kEntries = 16;
    uint32_t count;
    Entry entries[kEntries];
};

} // namespace sunstone::denoise::gpu
