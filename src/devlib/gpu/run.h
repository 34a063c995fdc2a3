// SPDX-License-Identifier: Apache-2.0
// Launch indices, and the kernel with one thread for each of them and warps as tiles. The kernels
// that loop are in loop.h and nested.h.
#pragma once

#include "devlib/gpu/exceptions.h"

namespace sunstone::devlib::gpu {

// A launch index by tile and place in it; false beyond the edges.
SUNSTONE_INLINE bool findIndex(const uint32_t size[3], uint32_t tile, uint32_t place,
                               uint32_t index[3]) {
    if (size[1] == 1) {
        const uint64_t number = uint64_t(tile) * kGpuTile + place;
        index[0] = uint32_t(number % size[0]);
        index[1] = 0;
        index[2] = uint32_t(number / size[0]);
        return index[2] < size[2];
    }
    const uint32_t columns = (size[0] + kGpuTileWidth - 1) / kGpuTileWidth;
    const uint32_t rows = (size[1] + kGpuTileHeight - 1) / kGpuTileHeight;
    index[0] = tile % columns * kGpuTileWidth + place % kGpuTileWidth;
    tile /= columns;
    index[1] = tile % rows * kGpuTileHeight + place / kGpuTileWidth;
    index[2] = tile / rows;
    return index[0] < size[0] && index[1] < size[1] && index[2] < size[2];
}

// Sets the state of a ray generation program, except the launch index.
SUNSTONE_INLINE void prepareRoot(const LaunchState& launch, RayState& state, ThreadState& thread) {
    thread.pad = 0;
    thread.exceptionCode = 0;
    thread.line = nullptr;
    if (sunstone_gpu_exceptionFlags & kFlagStackOverflow) // stacks grow downwards
        thread.stackLimit = reinterpret_cast<uint64_t>(&thread) - blockOf(&launch).stackBytes;
    // Otherwise nothing reads `root`, and state and thread can stay in registers.
    if (sunstone_gpu_hasException ||
        (sunstone_gpu_exceptionFlags & (kFlagStackOverflow | kFlagDebug)))
        thread.root = &state;
    state.launch = &launch;
    state.thread = &thread;
    state.sbtData = dataOf(launch.sbt.entryRecord);
    state.depth = 0;
    state.payloadType = state.payloadCount = 0;
    state.hit.transformCount = 0;
    state.hit.sbtGasIndex = 0;
}

// Sets the members that depend on the launch index.
SUNSTONE_INLINE void prepareEntry(RayState& root) {
    if (sunstone_gpu_hasBounds && root.launch->boxes)
        prepareBounds(root);
}

extern "C" void sunstone_gpu_run(LaunchBlock* block) {
    static_assert(kGpuBlockThreads % kGpuTile == 0);
    const LaunchState& launch = block->launch;
    const uint32_t thread = uint32_t(__nvvm_read_ptx_sreg_tid_x());
    const uint32_t tile = uint32_t(__nvvm_read_ptx_sreg_ctaid_x()) * (kGpuBlockThreads / kGpuTile) +
                          thread / kGpuTile;
    ThreadState index;
    if (!findIndex(launch.dimensions, tile, thread % kGpuTile, index.index))
        return;
    RayState state;
    prepareRoot(launch, state, index);
    prepareEntry(state);
    if (sunstone_gpu_raygen(&state, groupOf(launch, launch.sbt.entryRecord,
                                            GroupKind(launch.entryKind))) == kNoProgram)
        endLaunch(&state, kFatalRaygenRecord);
}

} // namespace sunstone::devlib::gpu
