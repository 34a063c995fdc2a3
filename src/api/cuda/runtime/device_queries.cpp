// SPDX-License-Identifier: Apache-2.0
// Less common device queries, and settings without effect: see sunstone/runtime_devices.h.
#include "api/cuda/runtime/arrays.h"
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

SUNSTONE_CUDART cudaError_t cudaSetValidDevices(int* devices, int count) {
    int available = 0;
    if (const cudaError_t error = cudaGetDeviceCount(&available))
        return error;
    if (count < 0 || count > available || (count > 0 && !devices))
        return remember(cudaErrorInvalidValue);
    for (int i = 0; i < count; ++i)
        if (devices[i] < 0 || devices[i] >= available)
            return remember(cudaErrorInvalidDevice);
    setFirstDevice(count ? devices[0] : 0);
    return cudaSuccess;
}

SUNSTONE_CUDART cudaError_t cudaDeviceGetP2PAttribute(int* value, enum cudaDeviceP2PAttr attribute,
                                                      int source, int destination) {
    const Driver& d = driver();
    return remember(d.status ? d.status
                             : present(d.cuDeviceGetP2PAttribute, value,
                                       static_cast<CUdevice_P2PAttribute>(attribute), source,
                                       destination));
}

SUNSTONE_CUDART cudaError_t cudaDeviceGetTexture1DLinearMaxWidth(
    size_t* texels, const struct cudaChannelFormatDesc* format, int device) {
    const Driver& d = driver();
    CUarray_format element;
    unsigned channels = 0;
    if (d.status)
        return remember(d.status);
    if (!texels || !format)
        return remember(cudaErrorInvalidValue);
    if (!toFormat(*format, &element, &channels))
        return remember(cudaErrorInvalidChannelDescriptor);
    return remember(
        present(d.cuDeviceGetTexture1DLinearMaxWidth, texels, element, channels, device));
}

SUNSTONE_CUDART cudaError_t cudaDeviceGetSharedMemConfig(enum cudaSharedMemConfig* config) {
    return call([&](const Driver& d) {
        return present(d.cuCtxGetSharedMemConfig, reinterpret_cast<CUsharedconfig*>(config));
    });
}
SUNSTONE_CUDART cudaError_t cudaDeviceSetSharedMemConfig(enum cudaSharedMemConfig config) {
    return call([&](const Driver& d) {
        return present(d.cuCtxSetSharedMemConfig, static_cast<CUsharedconfig>(config));
    });
}
SUNSTONE_CUDART cudaError_t cudaCtxResetPersistingL2Cache(void) {
    return call([](const Driver& d) { return present(d.cuCtxResetPersistingL2Cache); });
}
