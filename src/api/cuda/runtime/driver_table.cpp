// SPDX-License-Identifier: Apache-2.0
// Opens the driver, and sets the context of each thread.
#include "api/cuda/runtime/runtime.h"

#include <atomic>
#include <dlfcn.h>
#include <pthread.h>

namespace sunstone::cudart {

namespace {

#define SUNSTONE_TEXT2(name) #name
#define SUNSTONE_TEXT(name) SUNSTONE_TEXT2(name)

Driver openDriver() {
    Driver table;
    void* library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_GLOBAL);
    if (!library)
        return table;
#define SUNSTONE_LOAD(name)                                                                        \
    table.name = reinterpret_cast<decltype(table.name)>(dlsym(library, SUNSTONE_TEXT(name)));      \
    if (!table.name)                                                                               \
        return table;
    SUNSTONE_DRIVER_FUNCTIONS(SUNSTONE_LOAD)
#undef SUNSTONE_LOAD
#define SUNSTONE_LOAD(name)                                                                        \
    table.name = reinterpret_cast<decltype(table.name)>(dlsym(library, SUNSTONE_TEXT(name)));
    SUNSTONE_OPTIONAL_DRIVER_FUNCTIONS(SUNSTONE_LOAD)
#undef SUNSTONE_LOAD
    table.isCpuDevice = dlsym(library, "sunstone_cuda_is_cpu_device") != nullptr;
    table.status = fromDriver(table.cuInit(0));
    return table;
}

std::atomic<bool> isChild{false};
std::atomic<int> firstDevice{0};

} // namespace

const Driver& driver() {
    // Never destroyed: programs call the runtime from their destructors.
    static const Driver* const table = [] {
        const auto* const made = new Driver(openDriver());
        if (made->status == cudaSuccess)
            pthread_atfork(nullptr, nullptr, [] { isChild = true; });
        return made;
    }();
    return *table;
}

bool isForkedChild() {
    return isChild;
}

void setFirstDevice(int device) {
    firstDevice = device;
}

cudaError_t ensureContext() {
    const Driver& d = driver();
    if (d.status != cudaSuccess)
        return d.status;
    CUcontext current = nullptr;
    if (d.cuCtxGetCurrent(&current) == CUDA_SUCCESS && current)
        return cudaSuccess;
    // One reference for the process suffices; a reset releases it, and the next call retains again.
    unsigned flags = 0;
    int active = 0;
    CUresult result = d.cuDevicePrimaryCtxGetState(firstDevice, &flags, &active);
    (void)active;
    if (!result)
        result = d.cuDevicePrimaryCtxRetain(&current, firstDevice);
    if (!result)
        result = d.cuCtxSetCurrent(current);
    return fromDriver(result);
}

} // namespace sunstone::cudart
