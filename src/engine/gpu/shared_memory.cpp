// SPDX-License-Identifier: Apache-2.0
// See shared_memory.h.
#include "engine/gpu/shared_memory.h"

#include "base/error.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace sunstone::engine {

using namespace device::cuda;

GpuSharedMemory::~GpuSharedMemory() {
    try {
        ContextScope scope(context_);
        for (void* slab : slabs_)
            driver().memFree(CUdeviceptr(slab));
        for (const auto& [memory, size] : used_)
            if (size > kLargestSmall)
                driver().memFree(CUdeviceptr(memory));
    } catch (const Error&) { // the application has destroyed its context, and all memory with it
    }
}

// The driver grants more memory than host and GPU have together; a write to the excess kills the
// process.
void GpuSharedMemory::requireRoom(size_t bytes) {
    size_t free = 0, onGpu = 0;
    SUNSTONE_CU(memGetInfo, &free, &onGpu);
    const size_t onHost = size_t(sysconf(_SC_PHYS_PAGES)) * size_t(sysconf(_SC_PAGESIZE));
    if (bytes > onHost + onGpu)
        fail(Code::kOutOfMemory, bytes, " bytes that host and GPU share are more than the ", onHost,
             " bytes of the host and the ", onGpu, " of the GPU");
}

void* GpuSharedMemory::fromDriver(size_t bytes) {
    ContextScope scope(context_);
    requireRoom(bytes);
    CUdeviceptr memory = 0;
    SUNSTONE_CU(memAllocManaged, &memory, bytes, CU_MEM_ATTACH_GLOBAL);
    return reinterpret_cast<void*>(memory);
}

// A piece of this size, a power of two.
void* GpuSharedMemory::small(size_t bytes) {
    std::vector<void*>& list = free_[bytes];
    if (list.empty()) {
        auto* const slab = static_cast<std::byte*>(fromDriver(kSlab));
        slabs_.push_back(slab);
        for (size_t at = kSlab; at >= bytes; at -= bytes)
            list.push_back(slab + at - bytes);
    }
    void* const memory = list.back();
    list.pop_back();
    return memory;
}

void* GpuSharedMemory::allocate(size_t bytes) {
    const size_t size = std::bit_ceil(std::max(bytes, kLeast));
    const bool isSmall = size <= kLargestSmall;
    void* memory = nullptr;
    {
        std::lock_guard lock(mutex_);
        memory = isSmall ? small(size) : fromDriver(bytes);
        used_[memory] = isSmall ? size : bytes;
    }
    std::memset(memory, 0, bytes);
    return memory;
}

void GpuSharedMemory::free(void* memory) noexcept {
    if (!memory)
        return;
    std::lock_guard lock(mutex_);
    const auto found = used_.find(memory);
    if (found == used_.end())
        return;
    const size_t size = found->second;
    used_.erase(found);
    if (size <= kLargestSmall) {
        free_[size].push_back(memory);
        return;
    }
    try {
        ContextScope scope(context_);
        driver().memFree(CUdeviceptr(memory));
    } catch (const Error&) { // as above
    }
}

} // namespace sunstone::engine
