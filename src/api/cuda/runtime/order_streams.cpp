// SPDX-License-Identifier: Apache-2.0
// Stream functions: launches, events, callbacks, memory in stream order, queries. Compiled twice,
// see runtime.h.
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

namespace {

bool validShape(const dim3& grid, const dim3& block) {
    return grid.x && grid.y && grid.z && block.x && block.y && block.z && grid.x <= 0x7fffffffu &&
           grid.y <= 65535 && grid.z <= 65535 && block.x <= 1024 && block.y <= 1024 &&
           block.z <= 64 && block.x * block.y * block.z <= 1024;
}

// Finds the kernel, checks the launch shape, and calls `body`, which calls the driver.
template <class Body>
cudaError_t withKernel(const void* symbol, const dim3& grid, const dim3& block, size_t sharedBytes,
                       Body&& body) {
    return call([&](const Driver& d) {
        CUfunction function = nullptr;
        if (cudaError_t error = findFunction(symbol, &function))
            return error;
        if (!validShape(grid, block) || sharedBytes > 0xffffffffu)
            return cudaErrorInvalidConfiguration;
        return fromDriver(body(d, function, static_cast<unsigned>(sharedBytes)));
    });
}

cudaError_t launchKernel(const void* symbol, const dim3& grid, const dim3& block, void** args,
                         size_t sharedBytes, cudaStream_t stream) {
    return withKernel(symbol, grid, block, sharedBytes,
                      [&](const Driver& d, CUfunction function, unsigned shared) {
                          return d.cuLaunchKernel(function, grid.x, grid.y, grid.z, block.x,
                                                  block.y, block.z, shared, streamOf(stream), args,
                                                  nullptr);
                      });
}

// A callback with the runtime's error type, wrapped in one with the driver's.
struct Callback {
    cudaStreamCallback_t function;
    cudaStream_t stream;
    void* userData;
};
void runCallback(CUstream, CUresult status, void* data) {
    Callback* callback = static_cast<Callback*>(data);
    callback->function(callback->stream, fromDriver(status), callback->userData);
    delete callback;
}

cudaError_t recordEvent(cudaEvent_t event, cudaStream_t stream, unsigned flags) {
    return call(
        [&](const Driver& d) { return d.cuEventRecordWithFlags(event, streamOf(stream), flags); });
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaLaunchKernel(const void* function, dim3 gridDim, dim3 blockDim,
                                             void** args, size_t sharedBytes, cudaStream_t stream) {
    return launchKernel(function, gridDim, blockDim, args, sharedBytes, stream);
}
#ifdef __CUDA_API_PER_THREAD_DEFAULT_STREAM
SUNSTONE_CUDART cudaError_t __cudaLaunchKernel_ptsz(cudaKernel_t kernel, dim3 gridDim,
                                                    dim3 blockDim, void** args, size_t sharedBytes,
                                                    cudaStream_t stream) {
    return launchKernel(kernel, gridDim, blockDim, args, sharedBytes, stream);
}
#else
SUNSTONE_CUDART cudaError_t __cudaLaunchKernel(cudaKernel_t kernel, dim3 gridDim, dim3 blockDim,
                                               void** args, size_t sharedBytes,
                                               cudaStream_t stream) {
    return launchKernel(kernel, gridDim, blockDim, args, sharedBytes, stream);
}
#endif
SUNSTONE_CUDART cudaError_t cudaLaunchKernelExC(const cudaLaunchConfig_t* config,
                                                const void* function, void** args) {
    if (!config)
        return remember(cudaErrorInvalidValue);
    if (config->numAttrs == 0)
        return launchKernel(function, config->gridDim, config->blockDim, args,
                            config->dynamicSmemBytes, config->stream);
    return withKernel(function, config->gridDim, config->blockDim, config->dynamicSmemBytes,
                      [&](const Driver& d, CUfunction found, unsigned shared) {
                          CUlaunchConfig exact = {};
                          exact.gridDimX = config->gridDim.x;
                          exact.gridDimY = config->gridDim.y;
                          exact.gridDimZ = config->gridDim.z;
                          exact.blockDimX = config->blockDim.x;
                          exact.blockDimY = config->blockDim.y;
                          exact.blockDimZ = config->blockDim.z;
                          exact.sharedMemBytes = shared;
                          exact.hStream = streamOf(config->stream);
                          exact.attrs = reinterpret_cast<CUlaunchAttribute*>(config->attrs);
                          exact.numAttrs = config->numAttrs;
                          return d.cuLaunchKernelEx(&exact, found, args, nullptr);
                      });
}
SUNSTONE_CUDART cudaError_t cudaLaunchCooperativeKernel(const void* function, dim3 gridDim,
                                                        dim3 blockDim, void** args,
                                                        size_t sharedBytes, cudaStream_t stream) {
    return withKernel(function, gridDim, blockDim, sharedBytes,
                      [&](const Driver& d, CUfunction found, unsigned shared) {
                          if (!d.cuLaunchCooperativeKernel)
                              return CUDA_ERROR_NOT_SUPPORTED;
                          return d.cuLaunchCooperativeKernel(found, gridDim.x, gridDim.y, gridDim.z,
                                                             blockDim.x, blockDim.y, blockDim.z,
                                                             shared, streamOf(stream), args);
                      });
}

SUNSTONE_CUDART cudaError_t cudaMallocAsync(void** address, size_t bytes, cudaStream_t stream) {
    if (!address)
        return remember(cudaErrorInvalidValue);
    *address = nullptr;
    if (bytes == 0)
        return cudaSuccess;
    return call([&](const Driver& d) {
        CUdeviceptr result = 0;
        const CUresult error = d.cuMemAllocAsync(&result, bytes, streamOf(stream));
        *address = reinterpret_cast<void*>(result);
        return error;
    });
}
SUNSTONE_CUDART cudaError_t cudaMallocFromPoolAsync(void** address, size_t bytes,
                                                    cudaMemPool_t pool, cudaStream_t stream) {
    if (!address)
        return remember(cudaErrorInvalidValue);
    *address = nullptr;
    if (bytes == 0)
        return cudaSuccess;
    return call([&](const Driver& d) {
        CUdeviceptr result = 0;
        if (!d.cuMemAllocFromPoolAsync)
            return CUDA_ERROR_NOT_SUPPORTED;
        const CUresult error = d.cuMemAllocFromPoolAsync(&result, bytes, pool, streamOf(stream));
        *address = reinterpret_cast<void*>(result);
        return error;
    });
}
SUNSTONE_CUDART cudaError_t cudaFreeAsync(void* address, cudaStream_t stream) {
    if (!address)
        return cudaSuccess;
    return call(
        [&](const Driver& d) { return d.cuMemFreeAsync(addressOf(address), streamOf(stream)); });
}
SUNSTONE_CUDART cudaError_t SUNSTONE_SINCE_13(cudaMemPrefetchAsync, cudaMemPrefetchAsync_v2)(
    const void* address, size_t bytes, struct cudaMemLocation location, unsigned int flags,
    cudaStream_t stream) {
    const CUmemLocation place = {static_cast<CUmemLocationType>(location.type), location.id};
    return call([&](const Driver& d) {
        return d.cuMemPrefetchAsync
                   ? d.cuMemPrefetchAsync(addressOf(address), bytes, place, flags, streamOf(stream))
                   : CUDA_ERROR_NOT_SUPPORTED;
    });
}

SUNSTONE_CUDART cudaError_t cudaStreamQuery(cudaStream_t stream) {
    return call([&](const Driver& d) { return d.cuStreamQuery(streamOf(stream)); });
}
SUNSTONE_CUDART cudaError_t cudaStreamSynchronize(cudaStream_t stream) {
    return call([&](const Driver& d) { return d.cuStreamSynchronize(streamOf(stream)); });
}
SUNSTONE_CUDART cudaError_t cudaStreamWaitEvent(cudaStream_t stream, cudaEvent_t event,
                                                unsigned int flags) {
    return call(
        [&](const Driver& d) { return d.cuStreamWaitEvent(streamOf(stream), event, flags); });
}
SUNSTONE_CUDART cudaError_t cudaStreamAddCallback(cudaStream_t stream,
                                                  cudaStreamCallback_t callback, void* userData,
                                                  unsigned int flags) {
    if (!callback || flags)
        return remember(cudaErrorInvalidValue);
    return call([&](const Driver& d) {
        Callback* data = new Callback{callback, stream, userData};
        const CUresult result = d.cuStreamAddCallback(streamOf(stream), runCallback, data, 0);
        if (result)
            delete data;
        return result;
    });
}
SUNSTONE_CUDART cudaError_t cudaLaunchHostFunc(cudaStream_t stream, cudaHostFn_t function,
                                               void* userData) {
    return call(
        [&](const Driver& d) { return d.cuLaunchHostFunc(streamOf(stream), function, userData); });
}
SUNSTONE_CUDART cudaError_t cudaStreamGetFlags(cudaStream_t stream, unsigned int* flags) {
    return call([&](const Driver& d) { return d.cuStreamGetFlags(streamOf(stream), flags); });
}
SUNSTONE_CUDART cudaError_t cudaStreamGetPriority(cudaStream_t stream, int* priority) {
    return call([&](const Driver& d) { return d.cuStreamGetPriority(streamOf(stream), priority); });
}
SUNSTONE_CUDART cudaError_t cudaStreamGetDevice(cudaStream_t stream, int* device) {
    return call([&](const Driver& d) {
        return d.cuStreamGetDevice ? d.cuStreamGetDevice(streamOf(stream), device)
                                   : CUDA_ERROR_NOT_SUPPORTED;
    });
}
SUNSTONE_CUDART cudaError_t cudaStreamGetId(cudaStream_t stream, unsigned long long* id) {
    return call([&](const Driver& d) { return d.cuStreamGetId(streamOf(stream), id); });
}
SUNSTONE_CUDART cudaError_t cudaStreamIsCapturing(cudaStream_t stream,
                                                  enum cudaStreamCaptureStatus* status) {
    return call([&](const Driver& d) {
        return d.cuStreamIsCapturing(streamOf(stream),
                                     reinterpret_cast<CUstreamCaptureStatus*>(status));
    });
}
SUNSTONE_CUDART cudaError_t cudaStreamAttachMemAsync(cudaStream_t stream, void* address,
                                                     size_t length, unsigned int flags) {
    return call([&](const Driver& d) {
        return d.cuStreamAttachMemAsync(streamOf(stream), addressOf(address), length, flags);
    });
}
SUNSTONE_CUDART cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t stream) {
    return recordEvent(event, stream, 0);
}
SUNSTONE_CUDART cudaError_t cudaEventRecordWithFlags(cudaEvent_t event, cudaStream_t stream,
                                                     unsigned int flags) {
    return recordEvent(event, stream, flags);
}

SUNSTONE_CUDART cudaError_t cudaStreamGetAttribute(cudaStream_t stream,
                                                   enum cudaLaunchAttributeID attribute,
                                                   cudaLaunchAttributeValue* value) {
    return call([&](const Driver& d) {
        return d.cuStreamGetAttribute
                   ? d.cuStreamGetAttribute(streamOf(stream), static_cast<CUstreamAttrID>(attribute),
                                            reinterpret_cast<CUstreamAttrValue*>(value))
                   : CUDA_ERROR_NOT_SUPPORTED;
    });
}
SUNSTONE_CUDART cudaError_t cudaStreamSetAttribute(cudaStream_t stream,
                                                   enum cudaLaunchAttributeID attribute,
                                                   const cudaLaunchAttributeValue* value) {
    return call([&](const Driver& d) {
        return d.cuStreamSetAttribute
                   ? d.cuStreamSetAttribute(streamOf(stream), static_cast<CUstreamAttrID>(attribute),
                                            reinterpret_cast<const CUstreamAttrValue*>(value))
                   : CUDA_ERROR_NOT_SUPPORTED;
    });
}
SUNSTONE_CUDART cudaError_t cudaStreamCopyAttributes(cudaStream_t to, cudaStream_t from) {
    return call([&](const Driver& d) {
        return d.cuStreamCopyAttributes ? d.cuStreamCopyAttributes(streamOf(to), streamOf(from))
                                        : CUDA_ERROR_NOT_SUPPORTED;
    });
}
