// SPDX-License-Identifier: Apache-2.0
// Kernel launches: what a launch may ask for, and its execution as queued work.
#pragma once

#include "api/cuda/driver/module.h"

#include <cstddef>
#include <vector>

namespace sunstone::api::cuda {

struct LaunchRequest {
    CUfunction function = nullptr;
    unsigned grid[3] = {}, block[3] = {};
    unsigned sharedBytes = 0;
    void** params = nullptr;
    void** extra = nullptr;
};

// Most threads a block of this function may have.
unsigned maxThreadsOf(const Function& function);
// Most dynamic shared memory it may be launched with.
unsigned maxDynamicSharedOf(const Function& function);

// Checks everything, copies the parameters and queues the launch. Throws Failure with the code
// cuLaunchKernel documents.
void launch(const LaunchRequest& request, const cpu::StreamPtr& stream);

// How many blocks of this size a multiprocessor takes, by threads and shared memory.
unsigned activeBlocks(const Function& function, unsigned blockSize, size_t dynamicShared);

} // namespace sunstone::api::cuda
