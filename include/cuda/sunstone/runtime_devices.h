/* SPDX-License-Identifier: Apache-2.0
 * Less common device queries, and settings without effect, of the runtime API; part of
 * cuda_runtime_api.h. Source: CUDA runtime API, section on device management. */
#ifndef SUNSTONE_RUNTIME_DEVICES_H
#define SUNSTONE_RUNTIME_DEVICES_H

enum cudaDeviceP2PAttr {
    cudaDevP2PAttrPerformanceRank = 1,
    cudaDevP2PAttrAccessSupported = 2,
    cudaDevP2PAttrNativeAtomicSupported = 3,
    cudaDevP2PAttrCudaArrayAccessSupported = 4,
    cudaDevP2PAttrOnlyPartialNativeAtomicSupported = 5,
};

cudaError_t cudaSetValidDevices(int* devices, int count);
cudaError_t cudaDeviceGetP2PAttribute(int* value, enum cudaDeviceP2PAttr attribute, int source,
                                      int destination);
cudaError_t cudaDeviceGetTexture1DLinearMaxWidth(size_t* texels,
                                                 const struct cudaChannelFormatDesc* format,
                                                 int device);
cudaError_t cudaDeviceGetSharedMemConfig(enum cudaSharedMemConfig* config);
cudaError_t cudaDeviceSetSharedMemConfig(enum cudaSharedMemConfig config);
cudaError_t cudaFuncSetSharedMemConfig(const void* function, enum cudaSharedMemConfig config);
cudaError_t cudaCtxResetPersistingL2Cache(void);

#endif
