// SPDX-License-Identifier: Apache-2.0
// Copies from the host's memory to the device in stream order without blocking the host. A driver
// copies small blocks of pageable memory at once, but waits for the stream before it reads larger
// ones, and a graph reads the memory at its launch. This class therefore copies such blocks through
// page-locked memory.
#pragma once

#include "device/cuda/driver.h"

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace sunstone::bvh::gpu {

class Staging {
public:
    explicit Staging(const device::cuda::Driver& driver) : driver_(driver) {}
    // Requires that the context is current and that all queued copies have ended.
    ~Staging();
    Staging(const Staging&) = delete;
    Staging& operator=(const Staging&) = delete;

    // Queues the copy. The caller may change `from` after the call.
    CUresult copy(CUstream stream, CUdeviceptr to, const void* from, size_t size);

    // Call after the context was destroyed with its blocks: the destructor then does not call the
    // driver.
    void abandon() { blocks_.clear(); }

private:
    struct Block {
        void* memory = nullptr;
        size_t size = 0;
        CUevent done = nullptr;
        bool isTaken = false; // being filled, or a part of a graph
    };
    CUresult take(size_t size, Block*& block);

    const device::cuda::Driver& driver_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Block>> blocks_;
};

} // namespace sunstone::bvh::gpu
