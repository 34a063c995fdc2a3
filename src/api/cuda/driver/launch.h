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
    bool cooperative = false;
};

// Most threads a block of this function may have.
unsigned maxThreadsOf(const Function& function);
// Most dynamic shared memory it may be launched with.
unsigned maxDynamicSharedOf(const Function& function);

// A launch as graphs show it: its own copy of the parameters.
struct KernelDetails {
    LaunchRequest request;
    std::vector<void*> pointers; // request.params
};

// A launch that may run any number of times, also side by side.
struct PreparedLaunch {
    std::function<void()> work;
    std::shared_ptr<const KernelDetails> details;
};

// Checks everything and copies the parameters. Throws Failure with the code cuLaunchKernel
// documents.
PreparedLaunch prepareLaunch(const LaunchRequest& request);
// Prepares and queues.
void launch(const LaunchRequest& request, const cpu::StreamPtr& stream);

// How many blocks of this size a multiprocessor takes, by threads and shared memory.
unsigned activeBlocks(const Function& function, unsigned blockSize, size_t dynamicShared);

} // namespace sunstone::api::cuda
