// SPDX-License-Identifier: Apache-2.0
// Managed memory of a CUDA context in small and large pieces (Backend::allocateShared). The driver
// gives managed memory by pages; small pieces share slabs of it.
#pragma once

#include "device/cuda/driver.h"

#include <cstddef>
#include <map>
#include <mutex>
#include <vector>

namespace sunstone::engine {

// Any thread may call. The destructor frees all remaining pieces.
class GpuSharedMemory {
public:
    explicit GpuSharedMemory(CUcontext context) : context_(context) {}
    ~GpuSharedMemory();
    GpuSharedMemory(const GpuSharedMemory&) = delete;
    GpuSharedMemory& operator=(const GpuSharedMemory&) = delete;

    void* allocate(size_t bytes); // zeroed; throws kOutOfMemory
    void free(void* memory) noexcept;

private:
    static constexpr size_t kLeast = 128, kLargestSmall = 64 << 10, kSlab = 2 << 20;
    static void requireRoom(size_t bytes);
    void* fromDriver(size_t bytes);
    void* small(size_t bytes);

    const CUcontext context_;
    std::mutex mutex_;
    std::map<size_t, std::vector<void*>> free_; // small pieces, by size
    std::map<void*, size_t> used_;              // all pieces, with their sizes
    std::vector<void*> slabs_;
};

} // namespace sunstone::engine
