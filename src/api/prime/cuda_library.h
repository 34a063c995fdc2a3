// SPDX-License-Identifier: Apache-2.0
// The libcuda.so.1 of the process as OptiX Prime uses it: a GPU's driver or the CPU device's
// library. It is opened with the first CUDA context.
#pragma once

#include "base/error.h"

#include "cuda.h"

#include <cstdint>
#include <vector>

namespace sunstone::prime {

// Functions that both libraries have.
struct CudaFunctions {
    decltype(&::cuInit) init = nullptr;
    decltype(&::cuGetErrorName) getErrorName = nullptr;
    decltype(&::cuDeviceGetCount) deviceGetCount = nullptr;
    decltype(&::cuDeviceGet) deviceGet = nullptr;
    decltype(&::cuDeviceGetAttribute) deviceGetAttribute = nullptr;
    decltype(&::cuDevicePrimaryCtxRetain) primaryCtxRetain = nullptr;
    decltype(&::cuCtxGetCurrent) ctxGetCurrent = nullptr;
    decltype(&::cuCtxSetCurrent) ctxSetCurrent = nullptr;
    decltype(&::cuCtxPushCurrent) ctxPushCurrent = nullptr;
    decltype(&::cuCtxPopCurrent) ctxPopCurrent = nullptr;
    decltype(&::cuCtxGetDevice) ctxGetDevice = nullptr;
    decltype(&::cuPointerGetAttribute) pointerGetAttribute = nullptr;
    decltype(&::cuMemGetAddressRange) memGetAddressRange = nullptr;
    decltype(&::cuMemHostRegister) memHostRegister = nullptr;
    decltype(&::cuMemHostUnregister) memHostUnregister = nullptr;
    decltype(&::cuStreamGetCtx) streamGetCtx = nullptr;
    decltype(&::cuStreamIsCapturing) streamIsCapturing = nullptr;
    bool readsHandles = true; // handles are addresses; those of the CPU device are numbers
};

// Opens the library. Throws kNotInitialized if there is none, or no device.
const CudaFunctions& cuda();
// The same if the process has loaded libcuda.so.1; else null.
const CudaFunctions* loadedCuda();

// Throws kCudaError (kOutOfMemory) with the function and the code's name.
void check(CUresult result, const char* function);

// The devices of compute capability 3.0 and more, the fastest first.
std::vector<int> cudaDevices();

// The number of the device current on this thread, or -1.
int currentCudaDevice();

// Makes a CUcontext (null: none) current on this thread during its lifetime.
class CudaScope {
public:
    explicit CudaScope(void* context);
    ~CudaScope();
    CudaScope(const CudaScope&) = delete;
    CudaScope& operator=(const CudaScope&) = delete;

private:
    bool pushed_ = false;
};

// Whether CUDA owns the address, and the bytes from there to the end of the memory.
bool isCudaMemory(const void* address, uint64_t& bytesFromHere);

} // namespace sunstone::prime
