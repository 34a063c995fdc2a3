// SPDX-License-Identifier: Apache-2.0
// Libraries of the driver in the runtime API. findFunction finds their kernels, so they can be used
// like host symbols.
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

namespace {

// Drivers older than libraries lack the function.
template <class Function, class... Arguments>
cudaError_t callLibrary(Function Driver::*function, Arguments... arguments) {
    return call([&](const Driver& d) {
        return d.*function ? (d.*function)(arguments...) : CUDA_ERROR_NOT_SUPPORTED;
    });
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaLibraryLoadData(cudaLibrary_t* library, const void* code,
                                                enum cudaJitOption* jitOptions, void** jitValues,
                                                unsigned int jitCount,
                                                enum cudaLibraryOption* options, void** values,
                                                unsigned int count) {
    return callLibrary(&Driver::cuLibraryLoadData, library, code,
                       reinterpret_cast<CUjit_option*>(jitOptions), jitValues, jitCount,
                       reinterpret_cast<CUlibraryOption*>(options), values, count);
}
SUNSTONE_CUDART cudaError_t cudaLibraryLoadFromFile(cudaLibrary_t* library, const char* file,
                                                    enum cudaJitOption* jitOptions,
                                                    void** jitValues, unsigned int jitCount,
                                                    enum cudaLibraryOption* options, void** values,
                                                    unsigned int count) {
    return callLibrary(&Driver::cuLibraryLoadFromFile, library, file,
                       reinterpret_cast<CUjit_option*>(jitOptions), jitValues, jitCount,
                       reinterpret_cast<CUlibraryOption*>(options), values, count);
}
SUNSTONE_CUDART cudaError_t cudaLibraryUnload(cudaLibrary_t library) {
    const cudaError_t error = callLibrary(&Driver::cuLibraryUnload, library);
    if (!error)
        forgetLibrary(library);
    return error;
}
SUNSTONE_CUDART cudaError_t cudaLibraryGetKernel(cudaKernel_t* kernel, cudaLibrary_t library,
                                                 const char* name) {
    const cudaError_t error = callLibrary(&Driver::cuLibraryGetKernel, kernel, library, name);
    if (!error)
        keepLibraryKernel(*kernel, library);
    return error;
}
SUNSTONE_CUDART cudaError_t cudaLibraryGetKernelCount(unsigned int* count, cudaLibrary_t library) {
    return callLibrary(&Driver::cuLibraryGetKernelCount, count, library);
}
SUNSTONE_CUDART cudaError_t cudaLibraryEnumerateKernels(cudaKernel_t* kernels, unsigned int count,
                                                        cudaLibrary_t library) {
    unsigned int all = 0;
    cudaError_t error = callLibrary(&Driver::cuLibraryGetKernelCount, &all, library);
    if (!error)
        error = callLibrary(&Driver::cuLibraryEnumerateKernels, kernels, count, library);
    for (unsigned int i = 0; !error && i < count && i < all; ++i)
        keepLibraryKernel(kernels[i], library);
    return error;
}
SUNSTONE_CUDART cudaError_t cudaLibraryGetGlobal(void** address, size_t* bytes,
                                                 cudaLibrary_t library, const char* name) {
    return callLibrary(&Driver::cuLibraryGetGlobal, reinterpret_cast<CUdeviceptr*>(address), bytes,
                       library, name);
}
SUNSTONE_CUDART cudaError_t cudaLibraryGetManaged(void** address, size_t* bytes,
                                                  cudaLibrary_t library, const char* name) {
    return callLibrary(&Driver::cuLibraryGetManaged, reinterpret_cast<CUdeviceptr*>(address), bytes,
                       library, name);
}
SUNSTONE_CUDART cudaError_t cudaLibraryGetUnifiedFunction(void** function, cudaLibrary_t library,
                                                          const char* symbol) {
    return callLibrary(&Driver::cuLibraryGetUnifiedFunction, function, library, symbol);
}
SUNSTONE_CUDART cudaError_t cudaKernelSetAttributeForDevice(cudaKernel_t kernel,
                                                            enum cudaFuncAttribute attribute,
                                                            int value, int device) {
    if (attribute != cudaFuncAttributeMaxDynamicSharedMemorySize &&
        attribute != cudaFuncAttributePreferredSharedMemoryCarveout)
        return remember(cudaErrorInvalidValue);
    CUfunction function = nullptr;
    // The handle may also come from __cudaGetKernel, for a registered kernel.
    return call([&](const Driver& d) {
        if (device != 0)
            return cudaErrorInvalidDevice;
        if (cudaError_t error = findFunction(kernel, &function))
            return error;
        const auto which = static_cast<CUfunction_attribute>(attribute);
        CUkernel ofLibrary = nullptr;
        if (isLibraryKernel(kernel, &ofLibrary))
            return fromDriver(d.cuKernelSetAttribute(which, value, ofLibrary, device));
        return fromDriver(d.cuFuncSetAttribute(function, which, value));
    });
}
