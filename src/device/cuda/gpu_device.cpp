// SPDX-License-Identifier: Apache-2.0
// See gpu_device.h.
#include "device/cuda/gpu_device.h"

namespace sunstone::device::cuda {

GpuDevice::GpuDevice(CUcontext context) : context_(context) {
    ContextScope scope(context);
    CUdevice device = 0;
    SUNSTONE_CU(ctxGetDevice, &device);
    int major = 0, minor = 0;
    SUNSTONE_CU(deviceGetAttribute, &major, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR, device);
    SUNSTONE_CU(deviceGetAttribute, &minor, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR, device);
    computeCapability_ = unsigned(10 * major + minor);
    SUNSTONE_CU(driverGetVersion, &driverVersion_);
    char text[256] = "";
    SUNSTONE_CU(deviceGetName, text, int(sizeof text), device);
    name_ = message("Sunstone on ", text, " (compute capability ", major, ".", minor, ")");
}

void GpuDevice::enqueue(void*, std::function<void()>) {
    fail(Code::kNotSupported, "this operation is not available on GPUs yet");
}

const void* GpuDevice::streamContext(void* stream) {
    if (uintptr_t(stream) <= uintptr_t(CU_STREAM_PER_THREAD)) // the default streams
        return nullptr;
    ContextScope scope(context_);
    CUcontext owner = nullptr;
    const CUresult result = driver().streamGetCtx(CUstream(stream), &owner);
    if (result == CUDA_ERROR_INVALID_HANDLE || result == CUDA_ERROR_INVALID_VALUE)
        fail(Code::kInvalidValue, "stream = ", stream, " is no live stream");
    check(result, DriverNames::streamGetCtx);
    return owner;
}

bool GpuDevice::isIdle(void* stream) {
    ContextScope scope(context_);
    return cuda::isIdle(driver(), CUstream(stream));
}

void GpuDevice::synchronize(void* stream) {
    ContextScope scope(context_);
    SUNSTONE_CU(streamSynchronize, CUstream(stream));
}

void GpuDevice::synchronizeAll() {
    ContextScope scope(context_);
    SUNSTONE_CU(ctxSynchronize);
}

void* GpuDevice::currentContext() {
    CUcontext current = nullptr;
    SUNSTONE_CU(ctxGetCurrent, &current);
    return current;
}

bool GpuDevice::isAccessible(const void* address, size_t size) {
    ContextScope scope(context_);
    const Driver& driver = cuda::driver();
    auto place = CUdeviceptr(address);
    for (;;) {
        unsigned type = 0;
        if (driver.pointerGetAttribute(&type, CU_POINTER_ATTRIBUTE_MEMORY_TYPE, place) !=
            CUDA_SUCCESS)
            return false;
        CUdeviceptr base = 0;
        size_t bytes = 0;
        // The driver gives no range for memory of other kinds (registered, mapped).
        if (driver.memGetAddressRange(&base, &bytes, place) != CUDA_SUCCESS)
            return true;
        const size_t rest = base + bytes - place;
        if (size <= rest)
            return true;
        if (!isMappedByApplication(driver, place))
            return false;
        place += rest; // the following piece
        size -= rest;
    }
}

} // namespace sunstone::device::cuda
