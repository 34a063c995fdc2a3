// SPDX-License-Identifier: Apache-2.0
// Kernel launches: the limits of a launch, and its execution as queued work.
#pragma once

#include "api/cuda/driver/modules/module.h"

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

// The maximum number of threads per block for this function.
unsigned maxThreadsOf(const Function& function);
// The maximum dynamic shared memory for a launch, in bytes.
unsigned maxDynamicSharedOf(const Function& function);

// Parameters of a launch as graphs return them, with their own copy of the kernel's parameters.
struct KernelDetails {
    LaunchRequest request;
    std::vector<void*> pointers; // request.params
};

// A launch that may run any number of times, also concurrently.
struct PreparedLaunch {
    std::function<void()> work;
    std::shared_ptr<const KernelDetails> details;
};

// Checks and copies all parameters. Throws Failure with the codes documented for cuLaunchKernel.
PreparedLaunch prepareLaunch(const LaunchRequest& request);
// Prepares and queues a launch.
void launch(const LaunchRequest& request, const cpu::StreamPtr& stream);

// The number of blocks of this size that a multiprocessor holds, by threads and shared memory.
unsigned activeBlocks(const Function& function, unsigned blockSize, size_t dynamicShared);

} // namespace sunstone::api::cuda
