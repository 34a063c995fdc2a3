// SPDX-License-Identifier: Apache-2.0
// The kernel of a launch: one thread for each launch index, warps as tiles.
#pragma once

#include "devlib/gpu/exceptions.h"

namespace sunstone::devlib::gpu {

// The launch index of this thread; false behind the edges.
SUNSTONE_DEVICE bool findIndex(const uint32_t size[3], uint32_t index[3]) {
    const uint32_t thread = uint32_t(__nvvm_read_ptx_sreg_tid_x());
    const uint64_t number =
        uint64_t(uint32_t(__nvvm_read_ptx_sreg_ctaid_x())) * kGpuBlockThreads + thread;
    if (size[1] == 1) {
        index[0] = uint32_t(number % size[0]);
        index[1] = 0;
        index[2] = uint32_t(number / size[0]);
        return index[2] < size[2];
    }
    constexpr uint32_t kTile = kGpuTileWidth * kGpuTileHeight;
    const uint32_t columns = (size[0] + kGpuTileWidth - 1) / kGpuTileWidth;
    const uint32_t rows = (size[1] + kGpuTileHeight - 1) / kGpuTileHeight;
    uint32_t tile = uint32_t(number / kTile);
    const uint32_t lane = uint32_t(number % kTile);
    index[0] = tile % columns * kGpuTileWidth + lane % kGpuTileWidth;
    tile /= columns;
    index[1] = tile % rows * kGpuTileHeight + lane / kGpuTileWidth;
    index[2] = tile / rows;
    return index[0] < size[0] && index[1] < size[1] && index[2] < size[2];
}

extern "C" void sunstone_gpu_run(LaunchBlock* block) {
    const LaunchState& launch = block->launch;
    uint32_t index[3];
    if (!findIndex(launch.dimensions, index))
        return;
    ThreadState thread;
    for (int i = 0; i < 3; ++i)
        thread.index[i] = index[i];
    thread.pad = 0;
    thread.exceptionCode = 0;
    thread.line = nullptr;
    if (sunstone_gpu_exceptionFlags & kFlagStackOverflow) // stacks grow downwards
        thread.stackLimit = reinterpret_cast<uint64_t>(&thread) - block->stackBytes;
    RayState state;
    thread.root = &state;
    state.launch = &launch;
    state.thread = &thread;
    state.sbtData = dataOf(launch.sbt.raygenRecord);
    state.depth = 0;
    state.payloadType = state.payloadCount = 0;
    state.hit.transformCount = 0;
    state.hit.sbtGasIndex = 0;
    if (sunstone_gpu_raygen(&state, groupOf(&state, launch.sbt.raygenRecord, kGroupRaygen)) ==
        kNoProgram)
        endLaunch(&state, kFatalRaygenRecord);
}

} // namespace sunstone::devlib::gpu
