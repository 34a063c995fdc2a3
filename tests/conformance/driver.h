// SPDX-License-Identifier: Apache-2.0
// The few functions of libcuda.so.1 that a recording needs, from the library that the loader finds:
// a GPU's driver or Sunstone's.
#pragma once

#include <cuda.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace conformance {

// Prints the text and ends the process with `code`.
[[noreturn]] void quit(int code, const std::string& text);

#define CONFORMANCE_FUNCTIONS(X)                                                                   \
    X(cuInit)                                                                                      \
    X(cuDeviceGet)                                                                                 \
    X(cuDeviceGetName)                                                                             \
    X(cuDriverGetVersion)                                                                          \
    X(cuDevicePrimaryCtxRetain)                                                                    \
    X(cuCtxSetCurrent)                                                                             \
    X(cuCtxSynchronize)                                                                            \
    X(cuMemAlloc)                                                                                  \
    X(cuMemFree)                                                                                   \
    X(cuMemcpyHtoD)                                                                                \
    X(cuMemcpyDtoH)                                                                                \
    X(cuMemsetD8)                                                                                  \
    X(cuModuleLoadDataEx)                                                                          \
    X(cuModuleUnload)                                                                              \
    X(cuModuleGetFunction)                                                                         \
    X(cuLaunchKernel)                                                                              \
    X(cuArray3DCreate)                                                                             \
    X(cuArrayDestroy) X(cuMipmappedArrayCreate) X(cuMipmappedArrayGetLevel)                        \
        X(cuMipmappedArrayDestroy) X(cuMemcpy3D) X(cuTexObjectCreate) X(cuTexObjectDestroy)        \
            X(cuSurfObjectCreate) X(cuSurfObjectDestroy)

class Driver {
public:
    // Ends the process with code 77 where there is no library or no device.
    Driver();

    // The library's functions under their names (with the _v2 that cuda.h adds).
#define X(name) decltype(&::name) name = nullptr;
    CONFORMANCE_FUNCTIONS(X)
#undef X
    CUdeviceptr allocate(size_t size) const;
    void release(CUdeviceptr address) const;
    void copyIn(CUdeviceptr to, const void* from, size_t size) const;
    bool copyOut(void* to, CUdeviceptr from, size_t size) const;
    void clear(CUdeviceptr address, size_t size) const;
    // The device and its driver in one line.
    std::string describe() const;
    // A symbol that must exist.
    void* find(const char* name) const;

private:
    void* library_ = nullptr;
    CUdevice device_ = 0;
};

} // namespace conformance
