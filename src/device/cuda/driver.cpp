// SPDX-License-Identifier: Apache-2.0
// See driver.h.
#include "device/cuda/driver.h"

#include "base/config.h"

#include <dlfcn.h>

namespace sunstone::device::cuda {
namespace {

constexpr const char* kLibrary = "libcuda.so.1";

// Looks for a name that only the libcuda of this project's CPU device exports. Tests of the GPU
// back end on machines without a GPU set kGpuBackEnd, and the CPU device, which runs any PTX,
// counts as a GPU.
bool isCpuDevice(void* library) {
    return dlsym(library, "sunstone_cuda_is_cpu_device") != nullptr &&
           config(Setting::kGpuBackEnd) != "cpu-device";
}

Driver openDriver() {
    void* library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL); // never closed: the driver's threads
                                                             // keep running
    if (!library) {
        const char* reason = dlerror();
        fail(Code::kNotInitialized, "no CUDA driver: ", reason ? reason : kLibrary);
    }
    if (isCpuDevice(library))
        fail(Code::kNotSupported, kLibrary, " of this process is that of the CPU device");
    Driver driver;
    const auto find = [&](const char* name) {
        void* address = dlsym(library, name);
        if (!address)
            fail(Code::kNotSupported, "the CUDA driver is too old: ", kLibrary, " has no ", name);
        return address;
    };
#define SUNSTONE_CUDA_FIND(member, function)                                                       \
    driver.member = reinterpret_cast<decltype(driver.member)>(find(DriverNames::member));
    SUNSTONE_CUDA_FUNCTIONS(SUNSTONE_CUDA_FIND)
#undef SUNSTONE_CUDA_FIND
#define SUNSTONE_CUDA_FIND(member, function)                                                       \
    driver.member = reinterpret_cast<decltype(driver.member)>(dlsym(library, DriverNames::member));
    SUNSTONE_CUDA_NEWER_FUNCTIONS(SUNSTONE_CUDA_FIND)
#undef SUNSTONE_CUDA_FIND
    return driver;
}

} // namespace

LoadedDriver loadedDriver() {
    void* library = dlopen(kLibrary, RTLD_LAZY | RTLD_NOLOAD);
    if (!library)
        return LoadedDriver::kNone;
    const bool cpu = isCpuDevice(library);
    dlclose(library);
    return cpu ? LoadedDriver::kCpuDevice : LoadedDriver::kGpu;
}

Driver& driverForTests() {
    static Driver opened = openDriver(); // tried again after a failure
    return opened;
}

const Driver& driver() {
    return driverForTests();
}

void check(CUresult result, const char* function) {
    check(driver(), result, function);
}

void check(const Driver& driver, CUresult result, const char* function) {
    if (result == CUDA_SUCCESS)
        return;
    const char *name = nullptr, *text = nullptr;
    driver.getErrorName(result, &name);
    driver.getErrorString(result, &text);
    fail(result == CUDA_ERROR_OUT_OF_MEMORY ? Code::kOutOfMemory : Code::kCudaError, function, ": ",
         name ? name : "unknown error", " (", text ? text : message("code ", int(result)), ")");
}

ContextScope::~ContextScope() {
    driver().threadExchangeStreamCaptureMode(&mode_);
    CUcontext popped = nullptr;
    driver().ctxPopCurrent(&popped);
}

bool isMappedByApplication(const Driver& driver, CUdeviceptr address) {
    CUmemGenericAllocationHandle handle = 0;
    if (!driver.memRetainAllocationHandle || !driver.memRelease ||
        driver.memRetainAllocationHandle(&handle, reinterpret_cast<void*>(address)) != CUDA_SUCCESS)
        return false;
    driver.memRelease(handle);
    return true;
}

} // namespace sunstone::device::cuda
