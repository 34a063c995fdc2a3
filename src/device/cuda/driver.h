// SPDX-License-Identifier: Apache-2.0
// The CUDA driver of a GPU, opened at run time: a table of its functions, and errors as Error.
// Needs no toolkit and no import library; types and values come from include/cuda/cuda.h. Names in
// libcuda.so.1 are looked up only here.
//
//   using namespace device::cuda;
//   ContextScope current(context);              // of the calling thread, until the scope ends
//   SUNSTONE_CU(memAlloc, &address, bytes);     // throws Error("cuMemAlloc_v2: CUDA_ERROR_...")
#pragma once

#include "base/error.h"

#include "cuda.h"

namespace sunstone::device::cuda {

// Functions of every driver from CUDA 10.2 on; CudaDriver.NeedsOnlyFunctionsOfOldDrivers lists
// their names. Columns: member of Driver, name in cuda.h. Variants for the legacy default stream,
// because the engine passes explicit streams.
#define SUNSTONE_CUDA_FUNCTIONS(X)                                                                 \
    X(init, cuInit)                                                                                \
    X(driverGetVersion, cuDriverGetVersion)                                                        \
    X(getErrorName, cuGetErrorName)                                                                \
    X(getErrorString, cuGetErrorString)                                                            \
    X(deviceGetCount, cuDeviceGetCount)                                                            \
    X(deviceGet, cuDeviceGet)                                                                      \
    X(deviceGetName, cuDeviceGetName)                                                              \
    X(deviceGetAttribute, cuDeviceGetAttribute)                                                    \
    X(deviceTotalMem, cuDeviceTotalMem)                                                            \
    X(deviceGetPCIBusId, cuDeviceGetPCIBusId)                                                      \
    X(devicePrimaryCtxRetain, cuDevicePrimaryCtxRetain)                                            \
    X(ctxGetCurrent, cuCtxGetCurrent)                                                              \
    X(ctxPushCurrent, cuCtxPushCurrent)                                                            \
    X(ctxPopCurrent, cuCtxPopCurrent)                                                              \
    X(ctxGetDevice, cuCtxGetDevice)                                                                \
    X(ctxSynchronize, cuCtxSynchronize)                                                            \
    X(ctxSetLimit, cuCtxSetLimit)                                                                  \
    X(ctxGetLimit, cuCtxGetLimit)                                                                  \
    X(moduleLoadDataEx, cuModuleLoadDataEx)                                                        \
    X(linkCreate, cuLinkCreate)                                                                    \
    X(linkAddData, cuLinkAddData)                                                                  \
    X(linkComplete, cuLinkComplete)                                                                \
    X(linkDestroy, cuLinkDestroy)                                                                  \
    X(moduleUnload, cuModuleUnload)                                                                \
    X(moduleGetFunction, cuModuleGetFunction)                                                      \
    X(moduleGetGlobal, cuModuleGetGlobal)                                                          \
    X(memAlloc, cuMemAlloc)                                                                        \
    X(memAllocManaged, cuMemAllocManaged)                                                          \
    X(memGetInfo, cuMemGetInfo)                                                                    \
    X(memFree, cuMemFree)                                                                          \
    X(memAllocHost, cuMemAllocHost)                                                                \
    X(memFreeHost, cuMemFreeHost)                                                                  \
    X(memGetAddressRange, cuMemGetAddressRange)                                                    \
    X(pointerGetAttribute, cuPointerGetAttribute)                                                  \
    X(memcpyHtoD, cuMemcpyHtoD)                                                                    \
    X(memcpyDtoH, cuMemcpyDtoH)                                                                    \
    X(memcpyAsync, cuMemcpyAsync)                                                                  \
    X(memcpyHtoDAsync, cuMemcpyHtoDAsync)                                                          \
    X(memcpyDtoHAsync, cuMemcpyDtoHAsync)                                                          \
    X(memcpyDtoDAsync, cuMemcpyDtoDAsync)                                                          \
    X(memsetD8Async, cuMemsetD8Async)                                                              \
    X(memsetD32Async, cuMemsetD32Async)                                                            \
    X(memcpy3D, cuMemcpy3D)                                                                        \
    X(mipmappedArrayCreate, cuMipmappedArrayCreate)                                                \
    X(mipmappedArrayGetLevel, cuMipmappedArrayGetLevel)                                            \
    X(mipmappedArrayDestroy, cuMipmappedArrayDestroy)                                              \
    X(texObjectCreate, cuTexObjectCreate)                                                          \
    X(texObjectDestroy, cuTexObjectDestroy)                                                        \
    X(streamCreate, cuStreamCreate)                                                                \
    X(streamDestroy, cuStreamDestroy)                                                              \
    X(streamSynchronize, cuStreamSynchronize)                                                      \
    X(streamGetCtx, cuStreamGetCtx)                                                                \
    X(streamWaitEvent, cuStreamWaitEvent)                                                          \
    X(streamQuery, cuStreamQuery)                                                                  \
    X(streamIsCapturing, cuStreamIsCapturing)                                                      \
    X(launchHostFunc, cuLaunchHostFunc)                                                            \
    X(threadExchangeStreamCaptureMode, cuThreadExchangeStreamCaptureMode)                          \
    X(eventCreate, cuEventCreate)                                                                  \
    X(eventDestroy, cuEventDestroy)                                                                \
    X(eventRecord, cuEventRecord)                                                                  \
    X(eventQuery, cuEventQuery)                                                                    \
    X(eventSynchronize, cuEventSynchronize)                                                        \
    X(funcGetAttribute, cuFuncGetAttribute)                                                        \
    X(funcSetAttribute, cuFuncSetAttribute)                                                        \
    X(occupancyMaxActiveBlocksPerMultiprocessor, cuOccupancyMaxActiveBlocksPerMultiprocessor)      \
    X(launchKernel, cuLaunchKernel)

// Functions of newer drivers; null in the table of an older driver.
#define SUNSTONE_CUDA_NEWER_FUNCTIONS(X)                                                           \
    X(eventElapsedTime, cuEventElapsedTime)                                                        \
    X(memRetainAllocationHandle, cuMemRetainAllocationHandle)                                      \
    X(memRelease, cuMemRelease)                                                                    \
    X(streamGetCaptureInfo, cuStreamGetCaptureInfo_v2)                                             \
    X(userObjectCreate, cuUserObjectCreate)                                                        \
    X(userObjectRelease, cuUserObjectRelease)                                                      \
    X(graphRetainUserObject, cuGraphRetainUserObject)

struct Driver {
#define SUNSTONE_CUDA_MEMBER(member, function) decltype(&::function) member = nullptr;
    SUNSTONE_CUDA_FUNCTIONS(SUNSTONE_CUDA_MEMBER)
    SUNSTONE_CUDA_NEWER_FUNCTIONS(SUNSTONE_CUDA_MEMBER)
#undef SUNSTONE_CUDA_MEMBER
};

// The names under which the driver exports them.
struct DriverNames {
#define SUNSTONE_CUDA_TEXT_OF(text) #text
#define SUNSTONE_CUDA_TEXT(name) SUNSTONE_CUDA_TEXT_OF(name)
#define SUNSTONE_CUDA_MEMBER(member, function)                                                     \
    static constexpr const char* member = SUNSTONE_CUDA_TEXT(function);
    SUNSTONE_CUDA_FUNCTIONS(SUNSTONE_CUDA_MEMBER)
    SUNSTONE_CUDA_NEWER_FUNCTIONS(SUNSTONE_CUDA_MEMBER)
#undef SUNSTONE_CUDA_MEMBER
};

// Whether this process has loaded a libcuda.so.1, and which. Loads no library.
enum class LoadedDriver { kNone, kCpuDevice, kGpu };
LoadedDriver loadedDriver();

// The driver's functions. The first call opens libcuda.so.1. Throws Error(kNotInitialized) if there
// is no such library, and Error(kNotSupported) if it lacks a function or belongs to the CPU device.
const Driver& driver();
// The same table; a test may replace functions to make them fail.
Driver& driverForTests();

// Throws Error unless result is CUDA_SUCCESS: kOutOfMemory if memory ran out, else kCudaError. The
// text has the function and the driver's name and text of the code.
void check(CUresult result, const char* function);
void check(const Driver& driver, CUresult result, const char* function);

#define SUNSTONE_CU(member, ...)                                                                   \
    ::sunstone::device::cuda::check(::sunstone::device::cuda::driver().member(__VA_ARGS__),        \
                                    ::sunstone::device::cuda::DriverNames::member)

// Makes a context current on the calling thread during its lifetime. The thread may then allocate
// memory and query events while it or another thread captures a graph; these calls do not become
// part of the graph.
class ContextScope {
public:
    explicit ContextScope(CUcontext context) {
        SUNSTONE_CU(ctxPushCurrent, context);
        driver().threadExchangeStreamCaptureMode(&mode_);
    }
    ~ContextScope();
    ContextScope(const ContextScope&) = delete;
    ContextScope& operator=(const ContextScope&) = delete;

private:
    CUstreamCaptureMode mode_ = CU_STREAM_CAPTURE_MODE_RELAXED; // then the thread's own
};

// Whether work queued on the stream becomes part of a graph. Further queries, or waiting, would
// invalidate the capture.
inline bool isCapturing(const Driver& driver, CUstream stream) {
    CUstreamCaptureStatus status = CU_STREAM_CAPTURE_STATUS_NONE;
    return driver.streamIsCapturing(stream, &status) == CUDA_SUCCESS &&
           status != CU_STREAM_CAPTURE_STATUS_NONE;
}
// Whether a stream has no work left; false while it captures.
inline bool isIdle(const Driver& driver, CUstream stream) {
    return !isCapturing(driver, stream) && driver.streamQuery(stream) == CUDA_SUCCESS;
}

// Whether the application itself mapped memory to the address (cuMemMap). A buffer may then consist
// of several pieces, which may be replaced later. False if the driver cannot answer.
bool isMappedByApplication(const Driver& driver, CUdeviceptr address);

} // namespace sunstone::device::cuda
