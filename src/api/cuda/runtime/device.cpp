// SPDX-License-Identifier: Apache-2.0
// Versions, devices and device properties.
#include "api/cuda/runtime/runtime.h"

#include <cstring>

using namespace sunstone::cudart;

namespace {

// For calls that need the driver but no context.
template <class Body>
cudaError_t callDriver(Body&& body) {
    const Driver& d = driver();
    return remember(d.status != cudaSuccess ? d.status : fromDriver(body(d)));
}

// The member of cudaDeviceProp for an attribute.
struct Field {
    CUdevice_attribute attribute;
    size_t offset;
    size_t size; // of the field
};
#define FIELD(name, attribute)                                                                     \
    {                                                                                              \
        CU_DEVICE_ATTRIBUTE_##attribute, offsetof(cudaDeviceProp, name),                           \
            sizeof(cudaDeviceProp::name)                                                           \
    }
#define ELEMENT(name, index, attribute)                                                            \
    {                                                                                              \
        CU_DEVICE_ATTRIBUTE_##attribute, offsetof(cudaDeviceProp, name) + (index) * sizeof(int),   \
            sizeof(int)                                                                            \
    }
constexpr Field kFields[] = {
    FIELD(sharedMemPerBlock, MAX_SHARED_MEMORY_PER_BLOCK),
    FIELD(regsPerBlock, MAX_REGISTERS_PER_BLOCK),
    FIELD(warpSize, WARP_SIZE),
    FIELD(memPitch, MAX_PITCH),
    FIELD(maxThreadsPerBlock, MAX_THREADS_PER_BLOCK),
    ELEMENT(maxThreadsDim, 0, MAX_BLOCK_DIM_X),
    ELEMENT(maxThreadsDim, 1, MAX_BLOCK_DIM_Y),
    ELEMENT(maxThreadsDim, 2, MAX_BLOCK_DIM_Z),
    ELEMENT(maxGridSize, 0, MAX_GRID_DIM_X),
    ELEMENT(maxGridSize, 1, MAX_GRID_DIM_Y),
    ELEMENT(maxGridSize, 2, MAX_GRID_DIM_Z),
    FIELD(totalConstMem, TOTAL_CONSTANT_MEMORY),
    FIELD(major, COMPUTE_CAPABILITY_MAJOR),
    FIELD(minor, COMPUTE_CAPABILITY_MINOR),
    FIELD(textureAlignment, TEXTURE_ALIGNMENT),
    FIELD(texturePitchAlignment, TEXTURE_PITCH_ALIGNMENT),
    FIELD(multiProcessorCount, MULTIPROCESSOR_COUNT),
    FIELD(integrated, INTEGRATED),
    FIELD(canMapHostMemory, CAN_MAP_HOST_MEMORY),
    FIELD(maxTexture1D, MAXIMUM_TEXTURE1D_WIDTH),
    FIELD(maxTexture1DMipmap, MAXIMUM_TEXTURE1D_MIPMAPPED_WIDTH),
    ELEMENT(maxTexture2D, 0, MAXIMUM_TEXTURE2D_WIDTH),
    ELEMENT(maxTexture2D, 1, MAXIMUM_TEXTURE2D_HEIGHT),
    ELEMENT(maxTexture2DMipmap, 0, MAXIMUM_TEXTURE2D_MIPMAPPED_WIDTH),
    ELEMENT(maxTexture2DMipmap, 1, MAXIMUM_TEXTURE2D_MIPMAPPED_HEIGHT),
    ELEMENT(maxTexture2DLinear, 0, MAXIMUM_TEXTURE2D_LINEAR_WIDTH),
    ELEMENT(maxTexture2DLinear, 1, MAXIMUM_TEXTURE2D_LINEAR_HEIGHT),
    ELEMENT(maxTexture2DLinear, 2, MAXIMUM_TEXTURE2D_LINEAR_PITCH),
    ELEMENT(maxTexture2DGather, 0, MAXIMUM_TEXTURE2D_GATHER_WIDTH),
    ELEMENT(maxTexture2DGather, 1, MAXIMUM_TEXTURE2D_GATHER_HEIGHT),
    ELEMENT(maxTexture3D, 0, MAXIMUM_TEXTURE3D_WIDTH),
    ELEMENT(maxTexture3D, 1, MAXIMUM_TEXTURE3D_HEIGHT),
    ELEMENT(maxTexture3D, 2, MAXIMUM_TEXTURE3D_DEPTH),
    ELEMENT(maxTexture3DAlt, 0, MAXIMUM_TEXTURE3D_WIDTH_ALTERNATE),
    ELEMENT(maxTexture3DAlt, 1, MAXIMUM_TEXTURE3D_HEIGHT_ALTERNATE),
    ELEMENT(maxTexture3DAlt, 2, MAXIMUM_TEXTURE3D_DEPTH_ALTERNATE),
    FIELD(maxTextureCubemap, MAXIMUM_TEXTURECUBEMAP_WIDTH),
    ELEMENT(maxTexture1DLayered, 0, MAXIMUM_TEXTURE1D_LAYERED_WIDTH),
    ELEMENT(maxTexture1DLayered, 1, MAXIMUM_TEXTURE1D_LAYERED_LAYERS),
    ELEMENT(maxTexture2DLayered, 0, MAXIMUM_TEXTURE2D_LAYERED_WIDTH),
    ELEMENT(maxTexture2DLayered, 1, MAXIMUM_TEXTURE2D_LAYERED_HEIGHT),
    ELEMENT(maxTexture2DLayered, 2, MAXIMUM_TEXTURE2D_LAYERED_LAYERS),
    ELEMENT(maxTextureCubemapLayered, 0, MAXIMUM_TEXTURECUBEMAP_LAYERED_WIDTH),
    ELEMENT(maxTextureCubemapLayered, 1, MAXIMUM_TEXTURECUBEMAP_LAYERED_LAYERS),
    FIELD(maxSurface1D, MAXIMUM_SURFACE1D_WIDTH),
    ELEMENT(maxSurface2D, 0, MAXIMUM_SURFACE2D_WIDTH),
    ELEMENT(maxSurface2D, 1, MAXIMUM_SURFACE2D_HEIGHT),
    ELEMENT(maxSurface3D, 0, MAXIMUM_SURFACE3D_WIDTH),
    ELEMENT(maxSurface3D, 1, MAXIMUM_SURFACE3D_HEIGHT),
    ELEMENT(maxSurface3D, 2, MAXIMUM_SURFACE3D_DEPTH),
    ELEMENT(maxSurface1DLayered, 0, MAXIMUM_SURFACE1D_LAYERED_WIDTH),
    ELEMENT(maxSurface1DLayered, 1, MAXIMUM_SURFACE1D_LAYERED_LAYERS),
    ELEMENT(maxSurface2DLayered, 0, MAXIMUM_SURFACE2D_LAYERED_WIDTH),
    ELEMENT(maxSurface2DLayered, 1, MAXIMUM_SURFACE2D_LAYERED_HEIGHT),
    ELEMENT(maxSurface2DLayered, 2, MAXIMUM_SURFACE2D_LAYERED_LAYERS),
    FIELD(maxSurfaceCubemap, MAXIMUM_SURFACECUBEMAP_WIDTH),
    ELEMENT(maxSurfaceCubemapLayered, 0, MAXIMUM_SURFACECUBEMAP_LAYERED_WIDTH),
    ELEMENT(maxSurfaceCubemapLayered, 1, MAXIMUM_SURFACECUBEMAP_LAYERED_LAYERS),
    FIELD(surfaceAlignment, SURFACE_ALIGNMENT),
    FIELD(concurrentKernels, CONCURRENT_KERNELS),
    FIELD(ECCEnabled, ECC_ENABLED),
    FIELD(pciBusID, PCI_BUS_ID),
    FIELD(pciDeviceID, PCI_DEVICE_ID),
    FIELD(pciDomainID, PCI_DOMAIN_ID),
    FIELD(tccDriver, TCC_DRIVER),
    FIELD(asyncEngineCount, ASYNC_ENGINE_COUNT),
    FIELD(unifiedAddressing, UNIFIED_ADDRESSING),
    FIELD(memoryBusWidth, GLOBAL_MEMORY_BUS_WIDTH),
    FIELD(l2CacheSize, L2_CACHE_SIZE),
    FIELD(persistingL2CacheMaxSize, MAX_PERSISTING_L2_CACHE_SIZE),
    FIELD(maxThreadsPerMultiProcessor, MAX_THREADS_PER_MULTIPROCESSOR),
    FIELD(streamPrioritiesSupported, STREAM_PRIORITIES_SUPPORTED),
    FIELD(globalL1CacheSupported, GLOBAL_L1_CACHE_SUPPORTED),
    FIELD(localL1CacheSupported, LOCAL_L1_CACHE_SUPPORTED),
    FIELD(sharedMemPerMultiprocessor, MAX_SHARED_MEMORY_PER_MULTIPROCESSOR),
    FIELD(regsPerMultiprocessor, MAX_REGISTERS_PER_MULTIPROCESSOR),
    FIELD(managedMemory, MANAGED_MEMORY),
    FIELD(isMultiGpuBoard, MULTI_GPU_BOARD),
    FIELD(multiGpuBoardGroupID, MULTI_GPU_BOARD_GROUP_ID),
    FIELD(hostNativeAtomicSupported, HOST_NATIVE_ATOMIC_SUPPORTED),
    FIELD(pageableMemoryAccess, PAGEABLE_MEMORY_ACCESS),
    FIELD(concurrentManagedAccess, CONCURRENT_MANAGED_ACCESS),
    FIELD(computePreemptionSupported, COMPUTE_PREEMPTION_SUPPORTED),
    FIELD(canUseHostPointerForRegisteredMem, CAN_USE_HOST_POINTER_FOR_REGISTERED_MEM),
    FIELD(cooperativeLaunch, COOPERATIVE_LAUNCH),
    FIELD(sharedMemPerBlockOptin, MAX_SHARED_MEMORY_PER_BLOCK_OPTIN),
    FIELD(pageableMemoryAccessUsesHostPageTables, PAGEABLE_MEMORY_ACCESS_USES_HOST_PAGE_TABLES),
    FIELD(directManagedMemAccessFromHost, DIRECT_MANAGED_MEM_ACCESS_FROM_HOST),
    FIELD(maxBlocksPerMultiProcessor, MAX_BLOCKS_PER_MULTIPROCESSOR),
    FIELD(accessPolicyMaxWindowSize, MAX_ACCESS_POLICY_WINDOW_SIZE),
    FIELD(reservedSharedMemPerBlock, RESERVED_SHARED_MEMORY_PER_BLOCK),
    FIELD(hostRegisterSupported, HOST_REGISTER_SUPPORTED),
    FIELD(sparseCudaArraySupported, SPARSE_CUDA_ARRAY_SUPPORTED),
    FIELD(hostRegisterReadOnlySupported, READ_ONLY_HOST_REGISTER_SUPPORTED),
    FIELD(timelineSemaphoreInteropSupported, TIMELINE_SEMAPHORE_INTEROP_SUPPORTED),
    FIELD(memoryPoolsSupported, MEMORY_POOLS_SUPPORTED),
    FIELD(ipcEventSupported, IPC_EVENT_SUPPORTED),
    FIELD(clusterLaunch, CLUSTER_LAUNCH),
    FIELD(unifiedFunctionPointers, UNIFIED_FUNCTION_POINTERS),
};
#undef FIELD
#undef ELEMENT

} // namespace

SUNSTONE_CUDART cudaError_t cudaDriverGetVersion(int* version) {
    if (!version)
        return remember(cudaErrorInvalidValue);
    *version = 0; // no driver
    if (driver().status != cudaSuccess)
        return cudaSuccess;
    return callDriver([&](const Driver& d) { return d.cuDriverGetVersion(version); });
}
SUNSTONE_CUDART cudaError_t cudaRuntimeGetVersion(int* version) {
    if (!version)
        return remember(cudaErrorInvalidValue);
    *version = SUNSTONE_SINCE_13(CUDART_VERSION, 12090);
    return cudaSuccess;
}
SUNSTONE_CUDART cudaError_t cudaGetDeviceCount(int* count) {
    return callDriver([&](const Driver& d) { return d.cuDeviceGetCount(count); });
}
SUNSTONE_CUDART cudaError_t cudaGetDevice(int* device) {
    return call([&](const Driver& d) { return d.cuCtxGetDevice(device); });
}
SUNSTONE_CUDART cudaError_t cudaSetDevice(int device) {
    int count = 0;
    if (cudaError_t error = cudaGetDeviceCount(&count))
        return error;
    if (device < 0 || device >= count)
        return remember(cudaErrorInvalidDevice);
    return call([&](const Driver& d) {
        CUcontext context = nullptr;
        int current = -1;
        if (d.cuCtxGetDevice(&current) == CUDA_SUCCESS && current == device)
            return CUDA_SUCCESS;
        const CUresult result = d.cuDevicePrimaryCtxRetain(&context, device);
        return result ? result : d.cuCtxSetCurrent(context);
    });
}
SUNSTONE_CUDART cudaError_t cudaInitDevice(int device, unsigned int deviceFlags,
                                           unsigned int flags) {
    if (flags)
        if (cudaError_t error = cudaSetDeviceFlags(deviceFlags))
            return error;
    return cudaSetDevice(device);
}
SUNSTONE_CUDART cudaError_t cudaDeviceGetAttribute(int* value, enum cudaDeviceAttr attribute,
                                                   int device) {
    return callDriver([&](const Driver& d) {
        return d.cuDeviceGetAttribute(value, static_cast<CUdevice_attribute>(attribute), device);
    });
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaGetDeviceProperties, sunstoneGetDeviceProperties)(
    struct cudaDeviceProp* properties, int device) {
    if (!properties)
        return remember(cudaErrorInvalidValue);
    return callDriver([&](const Driver& d) {
        cudaDeviceProp result;
        std::memset(&result, 0, sizeof result);
        CUresult error = d.cuDeviceGetName(result.name, sizeof result.name, device);
        if (!error)
            error = d.cuDeviceTotalMem(&result.totalGlobalMem, device);
        if (!error)
            error = d.cuDeviceGetUuid(&result.uuid, device);
        for (const Field& field : kFields) {
            int value = 0;
            if (error)
                return error;
            error = d.cuDeviceGetAttribute(&value, field.attribute, device);
            char* to = reinterpret_cast<char*>(&result) + field.offset;
            const size_t wide = static_cast<size_t>(value);
            if (field.size == sizeof(size_t))
                std::memcpy(to, &wide, sizeof wide);
            else
                std::memcpy(to, &value, sizeof value);
        }
        if (!error)
            *properties = result;
        return error;
    });
}
SUNSTONE_CUDART cudaError_t cudaChooseDevice(int* device, const struct cudaDeviceProp* properties) {
    if (!device || !properties)
        return remember(cudaErrorInvalidValue);
    *device = 0;
    return cudaSuccess;
}
SUNSTONE_CUDART cudaError_t cudaSetDeviceFlags(unsigned int flags) {
    return callDriver([&](const Driver& d) { return d.cuDevicePrimaryCtxSetFlags(0, flags); });
}
SUNSTONE_CUDART cudaError_t cudaGetDeviceFlags(unsigned int* flags) {
    return call([&](const Driver& d) {
        int active = 0;
        const CUresult result = d.cuDevicePrimaryCtxGetState(0, flags, &active);
        if (!result)
            *flags |= cudaDeviceMapHost;
        return result;
    });
}
SUNSTONE_CUDART cudaError_t cudaDeviceSynchronize(void) {
    return call([](const Driver& d) { return d.cuCtxSynchronize(); });
}
SUNSTONE_CUDART cudaError_t cudaDeviceReset(void) {
    return callDriver([](const Driver& d) {
        if (isForkedChild())
            return CUDA_ERROR_NOT_INITIALIZED;
        forgetModules();
        d.cuCtxSetCurrent(nullptr);
        const CUresult result = d.cuDevicePrimaryCtxReset(0);
        if (result == CUDA_SUCCESS)
            forgetLastError();
        return result;
    });
}
SUNSTONE_CUDART cudaError_t cudaDeviceSetLimit(enum cudaLimit limit, size_t value) {
    return call(
        [&](const Driver& d) { return d.cuCtxSetLimit(static_cast<CUlimit>(limit), value); });
}
SUNSTONE_CUDART cudaError_t cudaDeviceGetLimit(size_t* value, enum cudaLimit limit) {
    return call(
        [&](const Driver& d) { return d.cuCtxGetLimit(value, static_cast<CUlimit>(limit)); });
}
SUNSTONE_CUDART cudaError_t cudaDeviceGetCacheConfig(enum cudaFuncCache* config) {
    return call([&](const Driver& d) {
        return d.cuCtxGetCacheConfig(reinterpret_cast<CUfunc_cache*>(config));
    });
}
SUNSTONE_CUDART cudaError_t cudaDeviceSetCacheConfig(enum cudaFuncCache config) {
    return call(
        [&](const Driver& d) { return d.cuCtxSetCacheConfig(static_cast<CUfunc_cache>(config)); });
}
SUNSTONE_CUDART cudaError_t cudaDeviceGetStreamPriorityRange(int* least, int* greatest) {
    return call([&](const Driver& d) { return d.cuCtxGetStreamPriorityRange(least, greatest); });
}
SUNSTONE_CUDART cudaError_t cudaDeviceGetPCIBusId(char* id, int length, int device) {
    return callDriver([&](const Driver& d) { return d.cuDeviceGetPCIBusId(id, length, device); });
}
SUNSTONE_CUDART cudaError_t cudaDeviceGetByPCIBusId(int* device, const char* id) {
    return callDriver([&](const Driver& d) { return d.cuDeviceGetByPCIBusId(device, id); });
}
SUNSTONE_CUDART cudaError_t cudaDeviceCanAccessPeer(int* canAccess, int device, int peer) {
    return callDriver(
        [&](const Driver& d) { return d.cuDeviceCanAccessPeer(canAccess, device, peer); });
}
SUNSTONE_CUDART cudaError_t cudaDeviceEnablePeerAccess(int, unsigned int) {
    return remember(cudaErrorInvalidDevice); // there is only one device
}
SUNSTONE_CUDART cudaError_t cudaDeviceDisablePeerAccess(int) {
    return remember(cudaErrorInvalidDevice);
}
SUNSTONE_CUDART cudaError_t cudaProfilerStart(void) {
    return cudaSuccess;
}
SUNSTONE_CUDART cudaError_t cudaProfilerStop(void) {
    return cudaSuccess;
}
