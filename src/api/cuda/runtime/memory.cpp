// SPDX-License-Identifier: Apache-2.0
// Allocation and pointer queries.
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

namespace {

// The runtime returns null for size 0, where the driver returns an error.
template <class Allocate>
cudaError_t allocate(void** address, size_t bytes, Allocate&& body) {
    if (!address)
        return remember(cudaErrorInvalidValue);
    *address = nullptr;
    return call([&](const Driver& d) { return bytes == 0 ? CUDA_SUCCESS : body(d); });
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaMalloc(void** address, size_t bytes) {
    return allocate(address, bytes, [&](const Driver& d) {
        return d.cuMemAlloc(reinterpret_cast<CUdeviceptr*>(address), bytes);
    });
}
SUNSTONE_CUDART cudaError_t cudaFree(void* address) {
    // With null it only initialises the runtime, as programs expect.
    return call([&](const Driver& d) { return d.cuMemFree(addressOf(address)); });
}
SUNSTONE_CUDART cudaError_t cudaHostAlloc(void** address, size_t bytes, unsigned int flags) {
    return allocate(address, bytes,
                    [&](const Driver& d) { return d.cuMemHostAlloc(address, bytes, flags); });
}
SUNSTONE_CUDART cudaError_t cudaMallocHost(void** address, size_t bytes) {
    return cudaHostAlloc(address, bytes, 0);
}
SUNSTONE_CUDART cudaError_t cudaFreeHost(void* address) {
    return call([&](const Driver& d) { return address ? d.cuMemFreeHost(address) : CUDA_SUCCESS; });
}
SUNSTONE_CUDART cudaError_t cudaHostGetDevicePointer(void** device, void* host,
                                                     unsigned int flags) {
    return call([&](const Driver& d) {
        return d.cuMemHostGetDevicePointer(reinterpret_cast<CUdeviceptr*>(device), host, flags);
    });
}
SUNSTONE_CUDART cudaError_t cudaHostGetFlags(unsigned int* flags, void* host) {
    return call([&](const Driver& d) { return d.cuMemHostGetFlags(flags, host); });
}
SUNSTONE_CUDART cudaError_t cudaHostRegister(void* address, size_t bytes, unsigned int flags) {
    return call([&](const Driver& d) { return d.cuMemHostRegister(address, bytes, flags); });
}
SUNSTONE_CUDART cudaError_t cudaHostUnregister(void* address) {
    return call([&](const Driver& d) { return d.cuMemHostUnregister(address); });
}
SUNSTONE_CUDART cudaError_t cudaMallocManaged(void** address, size_t bytes, unsigned int flags) {
    if (bytes == 0)
        return remember(cudaErrorInvalidValue);
    return allocate(address, bytes, [&](const Driver& d) {
        return d.cuMemAllocManaged(reinterpret_cast<CUdeviceptr*>(address), bytes, flags);
    });
}
SUNSTONE_CUDART cudaError_t cudaMallocPitch(void** address, size_t* pitch, size_t width,
                                            size_t height) {
    if (!pitch)
        return remember(cudaErrorInvalidValue);
    *pitch = 0;
    return allocate(address, width && height, [&](const Driver& d) {
        return d.cuMemAllocPitch(reinterpret_cast<CUdeviceptr*>(address), pitch, width, height, 4);
    });
}
SUNSTONE_CUDART cudaError_t cudaMalloc3D(struct cudaPitchedPtr* pitched, struct cudaExtent extent) {
    if (!pitched)
        return remember(cudaErrorInvalidValue);
    size_t rows = 0;
    if (__builtin_mul_overflow(extent.height, extent.depth, &rows))
        return remember(cudaErrorMemoryAllocation);
    pitched->xsize = extent.width;
    pitched->ysize = extent.height;
    return cudaMallocPitch(&pitched->ptr, &pitched->pitch, extent.width, rows);
}
SUNSTONE_CUDART cudaError_t cudaMemGetInfo(size_t* freeBytes, size_t* total) {
    return call([&](const Driver& d) { return d.cuMemGetInfo(freeBytes, total); });
}

namespace {

// Locations and advice have the same numbers in both APIs.
CUmemLocation placeOf(const cudaMemLocation& location) {
    return {static_cast<CUmemLocationType>(location.type), location.id};
}

} // namespace

SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaMemAdvise,
                                              cudaMemAdvise_v2)(const void* address, size_t bytes,
                                                                enum cudaMemoryAdvise advice,
                                                                struct cudaMemLocation location) {
    return call([&](const Driver& d) {
        return d.cuMemAdvise ? d.cuMemAdvise(addressOf(address), bytes,
                                             static_cast<CUmem_advise>(advice), placeOf(location))
                             : CUDA_ERROR_NOT_SUPPORTED;
    });
}
SUNSTONE_CUDART cudaError_t cudaMemRangeGetAttribute(void* data, size_t dataSize,
                                                     enum cudaMemRangeAttribute attribute,
                                                     const void* address, size_t bytes) {
    return call([&](const Driver& d) {
        return d.cuMemRangeGetAttribute
                   ? d.cuMemRangeGetAttribute(data, dataSize,
                                              static_cast<CUmem_range_attribute>(attribute),
                                              addressOf(address), bytes)
                   : CUDA_ERROR_NOT_SUPPORTED;
    });
}
SUNSTONE_CUDART cudaError_t cudaMemRangeGetAttributes(void** data, size_t* dataSizes,
                                                      enum cudaMemRangeAttribute* attributes,
                                                      size_t count, const void* address,
                                                      size_t bytes) {
    return call([&](const Driver& d) {
        return d.cuMemRangeGetAttributes
                   ? d.cuMemRangeGetAttributes(data, dataSizes,
                                               reinterpret_cast<CUmem_range_attribute*>(attributes),
                                               count, addressOf(address), bytes)
                   : CUDA_ERROR_NOT_SUPPORTED;
    });
}

SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaPointerGetAttributes,
                                              sunstonePointerGetAttributes)(
    struct cudaPointerAttributes* attributes, const void* address) {
    if (!attributes)
        return remember(cudaErrorInvalidValue);
    return call([&](const Driver& d) {
        unsigned type = 0, managed = 0;
        int device = 0;
        CUdeviceptr devicePointer = 0;
        void* hostPointer = nullptr;
        CUpointer_attribute names[] = {
            CU_POINTER_ATTRIBUTE_MEMORY_TYPE, CU_POINTER_ATTRIBUTE_IS_MANAGED,
            CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL, CU_POINTER_ATTRIBUTE_DEVICE_POINTER,
            CU_POINTER_ATTRIBUTE_HOST_POINTER};
        void* values[] = {&type, &managed, &device, &devicePointer, &hostPointer};
        const CUresult result = d.cuPointerGetAttributes(5, names, values, addressOf(address));
        if (result)
            return result;
        *attributes = {};
        attributes->type = managed                        ? cudaMemoryTypeManaged
                           : type == CU_MEMORYTYPE_DEVICE ? cudaMemoryTypeDevice
                           : type == CU_MEMORYTYPE_HOST   ? cudaMemoryTypeHost
                                                          : cudaMemoryTypeUnregistered;
        attributes->device = device;
        attributes->devicePointer = reinterpret_cast<void*>(devicePointer);
        // The application's own memory is its own host pointer.
        attributes->hostPointer = type || managed ? hostPointer : const_cast<void*>(address);
        return CUDA_SUCCESS;
    });
}

SUNSTONE_CUDART cudaError_t cudaMemcpyPeer(void* dst, int dstDevice, const void* src, int srcDevice,
                                           size_t bytes) {
    if (dstDevice != 0 || srcDevice != 0)
        return remember(cudaErrorInvalidDevice);
    return cudaMemcpy(dst, src, bytes, cudaMemcpyDeviceToDevice);
}
SUNSTONE_CUDART cudaError_t cudaMemcpyPeerAsync(void* dst, int dstDevice, const void* src,
                                                int srcDevice, size_t bytes, cudaStream_t stream) {
    if (dstDevice != 0 || srcDevice != 0)
        return remember(cudaErrorInvalidDevice);
    return cudaMemcpyAsync(dst, src, bytes, cudaMemcpyDeviceToDevice, stream);
}
