// SPDX-License-Identifier: Apache-2.0
#include "bvh/gpu/build/staging.h"

#include <algorithm>
#include <cstring>

namespace sunstone::bvh::gpu {

Staging::~Staging() {
    for (const auto& block : blocks_) {
        driver_.memFreeHost(block->memory);
        driver_.eventDestroy(block->done);
    }
}

// A block whose copy has ended, or a new one.
CUresult Staging::take(size_t size, Block*& block) {
    std::lock_guard lock(mutex_);
    for (const auto& each : blocks_)
        if (!each->isTaken && each->size >= size &&
            driver_.eventQuery(each->done) == CUDA_SUCCESS) {
            each->isTaken = true;
            block = each.get();
            return CUDA_SUCCESS;
        }
    constexpr size_t kLeast = 256 << 10;
    auto made = std::make_unique<Block>();
    made->size = std::max(kLeast, size + size / 4);
    made->isTaken = true;
    if (const CUresult result = driver_.memAllocHost(&made->memory, made->size))
        return result;
    if (const CUresult result = driver_.eventCreate(&made->done, CU_EVENT_DISABLE_TIMING)) {
        driver_.memFreeHost(made->memory);
        return result;
    }
    blocks_.push_back(std::move(made));
    block = blocks_.back().get();
    return CUDA_SUCCESS;
}

CUresult Staging::copy(CUstream stream, CUdeviceptr to, const void* from, size_t size) {
    constexpr size_t kTakenAtOnce = 64 << 10; // CUDA driver API, behaviour of copies
    const bool isCaptured = device::cuda::isCapturing(driver_, stream);
    if (!isCaptured && size <= kTakenAtOnce)
        return driver_.memcpyHtoDAsync(to, from, size, stream);
    Block* block = nullptr;
    if (const CUresult result = take(size, block))
        return result;
    std::memcpy(block->memory, from, size);
    CUresult result = driver_.memcpyHtoDAsync(to, block->memory, size, stream);
    if (isCaptured)
        return result; // the graph keeps the block
    const CUresult recorded = driver_.eventRecord(block->done, stream);
    if (recorded != CUDA_SUCCESS)
        driver_.streamSynchronize(stream);
    std::lock_guard lock(mutex_);
    block->isTaken = false;
    return result == CUDA_SUCCESS ? recorded : result;
}

} // namespace sunstone::bvh::gpu
