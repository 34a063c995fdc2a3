// SPDX-License-Identifier: Apache-2.0
#include "api/prime/cuda_library.h"

#include <dlfcn.h>

#include <algorithm>

namespace sunstone::prime {
namespace {

constexpr const char* kLibrary = "libcuda.so.1";

#define SUNSTONE_TEXT_OF(text) #text
#define SUNSTONE_TEXT(name) SUNSTONE_TEXT_OF(name)
#define SUNSTONE_FIND(member, function) find(functions.member, SUNSTONE_TEXT(function))

CudaFunctions open(void* library) {
    CudaFunctions functions;
    const auto find = [library](auto& member, const char* name) {
        void* const address = dlsym(library, name);
        if (!address)
            fail(Code::kNotInitialized, kLibrary, " has no ", name);
        member = reinterpret_cast<std::remove_reference_t<decltype(member)>>(address);
    };
    SUNSTONE_FIND(init, cuInit);
    SUNSTONE_FIND(getErrorName, cuGetErrorName);
    SUNSTONE_FIND(deviceGetCount, cuDeviceGetCount);
    SUNSTONE_FIND(deviceGet, cuDeviceGet);
    SUNSTONE_FIND(deviceGetAttribute, cuDeviceGetAttribute);
    SUNSTONE_FIND(primaryCtxRetain, cuDevicePrimaryCtxRetain);
    SUNSTONE_FIND(ctxGetCurrent, cuCtxGetCurrent);
    SUNSTONE_FIND(ctxSetCurrent, cuCtxSetCurrent);
    SUNSTONE_FIND(ctxPushCurrent, cuCtxPushCurrent);
    SUNSTONE_FIND(ctxPopCurrent, cuCtxPopCurrent);
    SUNSTONE_FIND(ctxGetDevice, cuCtxGetDevice);
    SUNSTONE_FIND(pointerGetAttribute, cuPointerGetAttribute);
    SUNSTONE_FIND(memGetAddressRange, cuMemGetAddressRange);
    SUNSTONE_FIND(memHostRegister, cuMemHostRegister);
    SUNSTONE_FIND(memHostUnregister, cuMemHostUnregister);
    SUNSTONE_FIND(streamGetCtx, cuStreamGetCtx);
    SUNSTONE_FIND(streamIsCapturing, cuStreamIsCapturing);
    functions.readsHandles = !dlsym(library, "sunstone_cuda_is_cpu_device");
    return functions;
}

} // namespace

const CudaFunctions& cuda() {
    static const auto* const functions = [] { // tried again after a failure
        void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL); // never closed
        if (!library) {
            const char* const reason = dlerror();
            fail(Code::kNotInitialized, "no CUDA driver: ", reason ? reason : kLibrary);
        }
        return new CudaFunctions(open(library));
    }();
    return *functions;
}

const CudaFunctions* loadedCuda() {
    void* const library = dlopen(kLibrary, RTLD_LAZY | RTLD_NOLOAD);
    if (!library)
        return nullptr;
    dlclose(library);
    return &cuda();
}

void check(CUresult result, const char* function) {
    if (result == CUDA_SUCCESS)
        return;
    const char* name = nullptr;
    cuda().getErrorName(result, &name);
    fail(result == CUDA_ERROR_OUT_OF_MEMORY ? Code::kOutOfMemory : Code::kCudaError, function, ": ",
         name ? name : "unknown error");
}

std::vector<int> cudaDevices() {
    const CudaFunctions& cu = cuda();
    int count = 0;
    if (cu.init(0) != CUDA_SUCCESS || cu.deviceGetCount(&count) != CUDA_SUCCESS)
        fail(Code::kNotInitialized, "the CUDA driver does not start, or finds no device");
    std::vector<std::pair<double, int>> found;
    for (int i = 0; i < count; ++i) {
        CUdevice device = 0;
        int major = 0, processors = 0, clock = 0;
        if (cu.deviceGet(&device, i) != CUDA_SUCCESS)
            continue;
        const auto ask = [&](int& value, CUdevice_attribute attribute) {
            cu.deviceGetAttribute(&value, attribute, device);
        };
        ask(major, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR);
        ask(processors, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT);
        ask(clock, CU_DEVICE_ATTRIBUTE_CLOCK_RATE);
        if (major >= 3)
            found.push_back({-double(processors) * std::max(clock, 1), i});
    }
    std::sort(found.begin(), found.end());
    std::vector<int> devices;
    for (const auto& [speed, device] : found)
        devices.push_back(device);
    return devices;
}

int currentCudaDevice() {
    const CudaFunctions* const cu = loadedCuda();
    CUdevice device = -1;
    return cu && cu->ctxGetDevice(&device) == CUDA_SUCCESS ? int(device) : -1;
}

CudaScope::CudaScope(void* context) {
    if (!context)
        return;
    check(cuda().ctxPushCurrent(static_cast<CUcontext>(context)), "cuCtxPushCurrent");
    pushed_ = true;
}

CudaScope::~CudaScope() {
    CUcontext popped = nullptr;
    if (pushed_)
        cuda().ctxPopCurrent(&popped);
}

bool isCudaMemory(const void* address, uint64_t& bytesFromHere) {
    const CudaFunctions* const cu = loadedCuda();
    unsigned type = 0;
    if (!cu || cu->pointerGetAttribute(&type, CU_POINTER_ATTRIBUTE_MEMORY_TYPE,
                                       CUdeviceptr(address)) != CUDA_SUCCESS)
        return false;
    CUdeviceptr base = 0;
    size_t size = 0;
    bytesFromHere = ~uint64_t(0); // page-locked host memory has no such range
    if (cu->memGetAddressRange(&base, &size, CUdeviceptr(address)) == CUDA_SUCCESS)
        bytesFromHere = base + size - CUdeviceptr(address);
    return true;
}

} // namespace sunstone::prime
