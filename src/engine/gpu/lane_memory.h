// SPDX-License-Identifier: Apache-2.0
// Device memory that warps of recursive launches claim (devlib/gpu/lane_memory.h): pools of slots
// of equal size. Launches of all pipelines share the pools; a pool lives as long as the context's
// back end, because graphs of captured launches refer to it.
#pragma once

#include "device/cuda/driver.h"
#include "devlib/gpu/launch_block.h"

#include <mutex>
#include <vector>

namespace sunstone::engine {

class GpuLaneMemory {
public:
    GpuLaneMemory() = default;
    GpuLaneMemory(const GpuLaneMemory&) = delete;
    GpuLaneMemory& operator=(const GpuLaneMemory&) = delete;

    // A pool for `warps` concurrent warps, with slots of at least slotBytes. If memory is short, it
    // has fewer slots, and warps wait for one another. With inStep it has all slots: a waiting warp
    // would block the warps of its block that have one. The context is current. Throws kOutOfMemory
    // if memory is too short for a few slots, or with inStep for all.
    devlib::LaneMemory obtain(uint64_t slotBytes, uint32_t warps, bool inStep);
    // Frees all pools; no launch is in progress, and the context is current.
    void release() noexcept;

private:
    static bool allocate(devlib::LaneMemory& pool, uint32_t words);

    std::mutex mutex_;
    std::vector<devlib::LaneMemory> pools_;
};

// Of the current context's GPU.
uint32_t multiprocessors();

// Warps of a kernel that the current context's GPU runs at a time.
uint32_t residentWarps(CUfunction kernel, unsigned blockThreads);

} // namespace sunstone::engine
