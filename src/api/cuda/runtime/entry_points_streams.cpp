// SPDX-License-Identifier: Apache-2.0
// Looks up functions of the driver by name. Compiled twice, see runtime.h: the default flag means
// the kind of default stream for which the caller was compiled.
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

namespace {

cudaError_t entryPoint(const char* symbol, void** function, unsigned int version,
                       unsigned long long flags, cudaDriverEntryPointQueryResult* status) {
    if (!symbol || !function || flags > cudaEnablePerThreadDefaultStream)
        return remember(cudaErrorInvalidValue);
    const Driver& d = driver();
    if (d.status != cudaSuccess)
        return remember(d.status);
    if (!d.cuGetProcAddress)
        return remember(cudaErrorNotSupported);
#ifdef __CUDA_API_PER_THREAD_DEFAULT_STREAM
    if (flags == cudaEnableDefault)
        flags = cudaEnablePerThreadDefaultStream;
#endif
    CUdriverProcAddressQueryResult found = CU_GET_PROC_ADDRESS_SUCCESS;
    const CUresult result =
        d.cuGetProcAddress(symbol, function, static_cast<int>(version), flags, &found);
    if (status)
        *status = static_cast<cudaDriverEntryPointQueryResult>(found);
    return remember(fromDriver(result));
}

} // namespace

SUNSTONE_CUDART cudaError_t
cudaGetDriverEntryPoint(const char* symbol, void** function, unsigned long long flags,
                        enum cudaDriverEntryPointQueryResult* driverStatus) {
#ifdef SUNSTONE_CUDART_12
    constexpr unsigned int kVersion = 12000;
#else
    constexpr unsigned int kVersion = CUDART_VERSION;
#endif
    return entryPoint(symbol, function, kVersion, flags, driverStatus);
}
SUNSTONE_CUDART cudaError_t cudaGetDriverEntryPointByVersion(
    const char* symbol, void** function, unsigned int cudaVersion, unsigned long long flags,
    enum cudaDriverEntryPointQueryResult* driverStatus) {
    return entryPoint(symbol, function, cudaVersion, flags, driverStatus);
}
