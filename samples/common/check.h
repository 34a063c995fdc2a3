// SPDX-License-Identifier: Apache-2.0
// Error checks: the samples wrap each call of the CUDA runtime and of OptiX in one of these macros,
// which throw std::runtime_error with the call, its place and the library's description.
#pragma once

#include <cuda_runtime.h>
#include <optix.h>
#include <optix_stubs.h>

#include <stdexcept>
#include <string>

[[noreturn]] inline void sampleFail(const char* call, const char* file, int line,
                                    const char* reason) {
    throw std::runtime_error(std::string(call) + " failed: " + reason + " (" + file + ":" +
                             std::to_string(line) + ")");
}

// Before optixInit has succeeded, there is no function table for a description.
inline const char* optixReason(OptixResult result) {
    if (result == OPTIX_ERROR_LIBRARY_NOT_FOUND)
        return "libnvoptix.so.1 was not found (start the program with `sunstone run`)";
    if (result == OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND)
        return "libnvoptix.so.1 lacks optixQueryFunctionTable";
    if (result == OPTIX_ERROR_UNSUPPORTED_ABI_VERSION)
        return "libnvoptix.so.1 does not support this version of the OptiX headers";
    return optixGetErrorString(result);
}

#define CUDA_CHECK(call)                                                                           \
    do {                                                                                           \
        cudaError_t result_ = (call);                                                              \
        if (result_ != cudaSuccess)                                                                \
            sampleFail(#call, __FILE__, __LINE__, cudaGetErrorString(result_));                    \
    } while (0)

#define OPTIX_CHECK(call)                                                                          \
    do {                                                                                           \
        OptixResult result_ = (call);                                                              \
        if (result_ != OPTIX_SUCCESS)                                                              \
            sampleFail(#call, __FILE__, __LINE__, optixReason(result_));                           \
    } while (0)
