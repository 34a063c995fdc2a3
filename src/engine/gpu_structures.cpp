// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu_structures.h"

#include "device/cuda/driver.h"

#include <algorithm>
#include <mutex>
#include <set>

namespace sunstone::engine {
namespace {

using namespace device::cuda;

struct Structures {
    std::mutex mutex;
    std::set<uint64_t> addresses;
    size_t most = 4096; // before those are looked for that are gone

    void forgetFreed() {
        for (auto address = addresses.begin(); address != addresses.end();)
            address = isAllocated(*address) ? std::next(address) : addresses.erase(address);
    }
    static bool isAllocated(uint64_t address) {
        unsigned type = 0;
        return driver().pointerGetAttribute(&type, CU_POINTER_ATTRIBUTE_MEMORY_TYPE, address) ==
               CUDA_SUCCESS;
    }
};

// One for the process: handles may be used in any of its contexts.
Structures& structures() {
    static Structures all;
    return all;
}

} // namespace

void noteGpuStructure(uint64_t address) {
    Structures& all = structures();
    std::lock_guard lock(all.mutex);
    if (all.addresses.size() >= all.most) {
        all.forgetFreed();
        all.most = std::max<size_t>(4096, 2 * all.addresses.size());
    }
    all.addresses.insert(address);
}

std::vector<uint64_t> liveGpuStructures() {
    Structures& all = structures();
    std::lock_guard lock(all.mutex);
    all.forgetFreed();
    return {all.addresses.begin(), all.addresses.end()};
}

} // namespace sunstone::engine
