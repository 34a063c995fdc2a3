// SPDX-License-Identifier: Apache-2.0
#include "device_memory.h"

#include "process_end.h"

#include <cuda.h>

#include <cstdlib>
#include <dlfcn.h>
#include <new>
#include <stdexcept>
#include <string>

namespace tests::api {
namespace {

struct Gpu {
    decltype(&::cuMemAllocManaged) allocate = nullptr;
    decltype(&::cuMemFree) free = nullptr;
    decltype(&::cuCtxSynchronize) wait = nullptr;
    decltype(&::cuCtxPushCurrent) push = nullptr;
    decltype(&::cuCtxPopCurrent) pop = nullptr;
    CUcontext context = nullptr;
    int computeCapability = 0, driverVersion = 0;

    bool isLost() const {
        if (push(context) != CUDA_SUCCESS)
            return true;
        const CUresult result = wait();
        CUcontext popped = nullptr;
        pop(&popped);
        return result != CUDA_SUCCESS;
    }
};

template <class Function>
Function find(void* library, const char* name) {
    void* address = dlsym(library, name);
    if (!address)
        throw std::runtime_error(std::string("libcuda.so.1 has no ") + name);
    return reinterpret_cast<Function>(address);
}

void require(CUresult result, const char* what) {
    if (result != CUDA_SUCCESS)
        throw std::runtime_error(std::string(what) + " failed with " + std::to_string(int(result)));
}

Gpu openGpu() {
    void* library = dlopen("libcuda.so.1", RTLD_NOW);
    if (!library)
        throw std::runtime_error(dlerror());
    require(find<decltype(&::cuInit)>(library, "cuInit")(0), "cuInit");
    CUcontext context = nullptr;
    require(find<decltype(&::cuDevicePrimaryCtxRetain)>(library,
                                                        "cuDevicePrimaryCtxRetain")(&context, 0),
            "cuDevicePrimaryCtxRetain");
    require(find<decltype(&::cuCtxSetCurrent)>(library, "cuCtxSetCurrent")(context),
            "cuCtxSetCurrent");
    const auto attribute = find<decltype(&::cuDeviceGetAttribute)>(library, "cuDeviceGetAttribute");
    int major = 0, minor = 0, version = 0;
    require(attribute(&major, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR, 0),
            "cuDeviceGetAttribute");
    require(attribute(&minor, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR, 0),
            "cuDeviceGetAttribute");
    require(find<decltype(&::cuDriverGetVersion)>(library, "cuDriverGetVersion")(&version),
            "cuDriverGetVersion");
    return {find<decltype(&::cuMemAllocManaged)>(library, "cuMemAllocManaged"),
            find<decltype(&::cuMemFree)>(library, "cuMemFree_v2"),
            find<decltype(&::cuCtxSynchronize)>(library, "cuCtxSynchronize"),
            find<decltype(&::cuCtxPushCurrent)>(library, "cuCtxPushCurrent_v2"),
            find<decltype(&::cuCtxPopCurrent)>(library, "cuCtxPopCurrent_v2"),
            context,
            10 * major + minor,
            version};
}

// Null where the tests run on the CPU.
const Gpu* gpu() {
    static const bool wanted = std::getenv("SUNSTONE_TEST_GPU") != nullptr;
    if (!wanted)
        return nullptr;
    static const Gpu opened = openGpu();
    return &opened;
}

} // namespace

void prepareDevice() {
    static const bool isPrepared = [] {
        if (!gpu())
            return false;
        tellFaults();
        limitTests();
        endWithContext([] { return gpu()->isLost(); });
        return true;
    }();
    (void)isPrepared;
}

bool onGpu() {
    return gpu() != nullptr;
}

int computeCapability() {
    return onGpu() ? gpu()->computeCapability : 0;
}

int driverVersion() {
    return onGpu() ? gpu()->driverVersion : 0;
}

void prepareThread() {
    if (onGpu())
        require(gpu()->push(gpu()->context), "cuCtxPushCurrent");
}

void* allocateDevice(size_t size, size_t alignment) {
    if (const Gpu* driver = gpu()) {
        CUdeviceptr memory = 0;                                 // aligned to 512 bytes at least
        if (driver->allocate(&memory, size, 1) != CUDA_SUCCESS) // CU_MEM_ATTACH_GLOBAL
            throw std::bad_alloc();
        return reinterpret_cast<void*>(memory);
    }
    void* memory = nullptr;
    if (posix_memalign(&memory, alignment, size) != 0)
        throw std::bad_alloc();
    return memory;
}

void freeDevice(void* memory) {
    if (!memory)
        return;
    if (const Gpu* driver = gpu()) {
        driver->wait();
        driver->free(reinterpret_cast<CUdeviceptr>(memory));
    } else {
        std::free(memory);
    }
}

} // namespace tests::api
