// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/lane_memory.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

constexpr uint32_t kWordBits = 32;

// Few sizes of slots, so that a context has few pools: 1 and 1.5 times powers of two.
uint64_t sizeClassOf(uint64_t bytes) {
    const uint64_t power = std::bit_ceil(bytes);
    return power / 4 * 3 >= bytes ? power / 4 * 3 : power;
}

} // namespace

// The slots come first, then the set of free ones.
bool GpuLaneMemory::allocate(devlib::LaneMemory& pool, uint32_t words) {
    const uint64_t slots = uint64_t(words) * kWordBits * pool.slotBytes;
    CUdeviceptr memory = 0;
    const CUresult result = driver().memAlloc(&memory, slots + words * sizeof(uint32_t));
    if (result == CUDA_ERROR_OUT_OF_MEMORY)
        return false;
    check(result, DriverNames::memAlloc);
    pool.slots = memory;
    pool.freeSlots = memory + slots;
    pool.words = words;
    const std::vector<uint32_t> allFree(words, ~0u);
    SUNSTONE_CU(memcpyHtoD, pool.freeSlots, allFree.data(), words * sizeof(uint32_t));
    return true;
}

devlib::LaneMemory GpuLaneMemory::obtain(uint64_t slotBytes, uint32_t warps, bool inStep) {
    const uint64_t size = sizeClassOf(slotBytes);
    if (size > UINT32_MAX)
        fail(Code::kNotSupported, "waiting programs of a warp take ", slotBytes,
             " bytes, which is more than 4 GiB");
    uint32_t words = std::max((warps + kWordBits - 1) / kWordBits, 1u);
    std::lock_guard lock(mutex_);
    for (const devlib::LaneMemory& pool : pools_)
        if (pool.slotBytes == size && pool.words >= words)
            return pool;
    devlib::LaneMemory pool{};
    pool.slotBytes = uint32_t(size);
    while (!allocate(pool, words)) {
        if (words == 1 || inStep)
            fail(Code::kOutOfMemory, "no device memory for waiting programs: ", size,
                 " bytes for each of ", words * kWordBits, " warps");
        words /= 2;
    }
    pools_.push_back(pool);
    return pool;
}

void GpuLaneMemory::release() noexcept {
    for (const devlib::LaneMemory& pool : pools_)
        driver().memFree(pool.slots);
    pools_.clear();
}

uint32_t multiprocessors() {
    CUdevice device = 0;
    int processors = 0;
    SUNSTONE_CU(ctxGetDevice, &device);
    SUNSTONE_CU(deviceGetAttribute, &processors, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT, device);
    return uint32_t(std::max(processors, 1));
}

uint32_t residentWarps(CUfunction kernel, unsigned blockThreads) {
    int blocks = 0;
    SUNSTONE_CU(occupancyMaxActiveBlocksPerMultiprocessor, &blocks, kernel, int(blockThreads), 0);
    return uint32_t(std::max(blocks, 1)) * multiprocessors() * (blockThreads / devlib::kGpuTile);
}

} // namespace sunstone::engine
