// SPDX-License-Identifier: Apache-2.0
// C++ templates over the runtime API: typed pointers, symbols and kernels as arguments.
#ifndef SUNSTONE_RUNTIME_TEMPLATES_H
#define SUNSTONE_RUNTIME_TEMPLATES_H

#include "../cuda_runtime_api.h"

#ifdef __cplusplus

#define SUNSTONE_HOST static __inline__ __host__

template <class T>
SUNSTONE_HOST cudaError_t cudaMalloc(T** address, size_t bytes) {
    return ::cudaMalloc((void**)address, bytes);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMallocHost(T** address, size_t bytes, unsigned int flags = 0) {
    return ::cudaHostAlloc((void**)address, bytes, flags);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaHostAlloc(T** address, size_t bytes, unsigned int flags) {
    return ::cudaHostAlloc((void**)address, bytes, flags);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaHostGetDevicePointer(T** device, void* host, unsigned int flags) {
    return ::cudaHostGetDevicePointer((void**)device, host, flags);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMallocManaged(T** address, size_t bytes,
                                            unsigned int flags = cudaMemAttachGlobal) {
    return ::cudaMallocManaged((void**)address, bytes, flags);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMallocPitch(T** address, size_t* pitch, size_t width, size_t height) {
    return ::cudaMallocPitch((void**)address, pitch, width, height);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMallocAsync(T** address, size_t bytes, cudaStream_t stream) {
    return ::cudaMallocAsync((void**)address, bytes, stream);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMallocAsync(T** address, size_t bytes, cudaMemPool_t pool,
                                          cudaStream_t stream) {
    return ::cudaMallocFromPoolAsync((void**)address, bytes, pool, stream);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMallocFromPoolAsync(T** address, size_t bytes, cudaMemPool_t pool,
                                                  cudaStream_t stream) {
    return ::cudaMallocFromPoolAsync((void**)address, bytes, pool, stream);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaStreamAttachMemAsync(cudaStream_t stream, T* address,
                                                   size_t length = 0,
                                                   unsigned int flags = cudaMemAttachSingle) {
    return ::cudaStreamAttachMemAsync(stream, (void*)address, length, flags);
}

template <class T>
SUNSTONE_HOST cudaError_t cudaLibraryGetGlobal(T** address, size_t* bytes, cudaLibrary_t library,
                                               const char* name) {
    return ::cudaLibraryGetGlobal((void**)address, bytes, library, name);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaLibraryGetManaged(T** address, size_t* bytes, cudaLibrary_t library,
                                                const char* name) {
    return ::cudaLibraryGetManaged((void**)address, bytes, library, name);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaLibraryGetUnifiedFunction(T** function, cudaLibrary_t library,
                                                        const char* symbol) {
    return ::cudaLibraryGetUnifiedFunction((void**)function, library, symbol);
}

// A symbol is a variable of the program marked __device__ or __constant__.
template <class T>
SUNSTONE_HOST cudaError_t cudaMemcpyToSymbol(const T& symbol, const void* src, size_t bytes,
                                             size_t offset = 0,
                                             enum cudaMemcpyKind kind = cudaMemcpyHostToDevice) {
    return ::cudaMemcpyToSymbol((const void*)&symbol, src, bytes, offset, kind);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMemcpyFromSymbol(void* dst, const T& symbol, size_t bytes,
                                               size_t offset = 0,
                                               enum cudaMemcpyKind kind = cudaMemcpyDeviceToHost) {
    return ::cudaMemcpyFromSymbol(dst, (const void*)&symbol, bytes, offset, kind);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMemcpyToSymbolAsync(const T& symbol, const void* src, size_t bytes,
                                                  size_t offset = 0,
                                                  enum cudaMemcpyKind kind = cudaMemcpyHostToDevice,
                                                  cudaStream_t stream = 0) {
    return ::cudaMemcpyToSymbolAsync((const void*)&symbol, src, bytes, offset, kind, stream);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaMemcpyFromSymbolAsync(
    void* dst, const T& symbol, size_t bytes, size_t offset = 0,
    enum cudaMemcpyKind kind = cudaMemcpyDeviceToHost, cudaStream_t stream = 0) {
    return ::cudaMemcpyFromSymbolAsync(dst, (const void*)&symbol, bytes, offset, kind, stream);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGetSymbolAddress(void** address, const T& symbol) {
    return ::cudaGetSymbolAddress(address, (const void*)&symbol);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGetSymbolSize(size_t* bytes, const T& symbol) {
    return ::cudaGetSymbolSize(bytes, (const void*)&symbol);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGraphAddMemcpyNodeToSymbol(
    cudaGraphNode_t* node, cudaGraph_t graph, const cudaGraphNode_t* dependencies, size_t count,
    const T& symbol, const void* src, size_t bytes, size_t offset, enum cudaMemcpyKind kind) {
    return ::cudaGraphAddMemcpyNodeToSymbol(node, graph, dependencies, count, (const void*)&symbol,
                                            src, bytes, offset, kind);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGraphAddMemcpyNodeFromSymbol(
    cudaGraphNode_t* node, cudaGraph_t graph, const cudaGraphNode_t* dependencies, size_t count,
    void* dst, const T& symbol, size_t bytes, size_t offset, enum cudaMemcpyKind kind) {
    return ::cudaGraphAddMemcpyNodeFromSymbol(node, graph, dependencies, count, dst,
                                              (const void*)&symbol, bytes, offset, kind);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGraphMemcpyNodeSetParamsToSymbol(cudaGraphNode_t node,
                                                               const T& symbol, const void* src,
                                                               size_t bytes, size_t offset,
                                                               enum cudaMemcpyKind kind) {
    return ::cudaGraphMemcpyNodeSetParamsToSymbol(node, (const void*)&symbol, src, bytes, offset,
                                                  kind);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGraphMemcpyNodeSetParamsFromSymbol(cudaGraphNode_t node, void* dst,
                                                                 const T& symbol, size_t bytes,
                                                                 size_t offset,
                                                                 enum cudaMemcpyKind kind) {
    return ::cudaGraphMemcpyNodeSetParamsFromSymbol(node, dst, (const void*)&symbol, bytes, offset,
                                                    kind);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGraphExecMemcpyNodeSetParamsToSymbol(
    cudaGraphExec_t exec, cudaGraphNode_t node, const T& symbol, const void* src, size_t bytes,
    size_t offset, enum cudaMemcpyKind kind) {
    return ::cudaGraphExecMemcpyNodeSetParamsToSymbol(exec, node, (const void*)&symbol, src, bytes,
                                                      offset, kind);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGraphExecMemcpyNodeSetParamsFromSymbol(
    cudaGraphExec_t exec, cudaGraphNode_t node, void* dst, const T& symbol, size_t bytes,
    size_t offset, enum cudaMemcpyKind kind) {
    return ::cudaGraphExecMemcpyNodeSetParamsFromSymbol(exec, node, dst, (const void*)&symbol,
                                                        bytes, offset, kind);
}

SUNSTONE_HOST cudaError_t cudaEventCreate(cudaEvent_t* event, unsigned int flags) {
    return ::cudaEventCreateWithFlags(event, flags);
}

// Kernels as function pointers.
template <class T>
SUNSTONE_HOST cudaError_t cudaFuncGetAttributes(struct cudaFuncAttributes* attributes, T* kernel) {
    return ::cudaFuncGetAttributes(attributes, (const void*)kernel);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaFuncSetAttribute(T* kernel, enum cudaFuncAttribute attribute,
                                               int value) {
    return ::cudaFuncSetAttribute((const void*)kernel, attribute, value);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaFuncSetCacheConfig(T* kernel, enum cudaFuncCache config) {
    return ::cudaFuncSetCacheConfig((const void*)kernel, config);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaFuncSetSharedMemConfig(T* kernel, enum cudaSharedMemConfig config) {
    return ::cudaFuncSetSharedMemConfig((const void*)kernel, config);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaLaunchKernel(T* kernel, dim3 gridDim, dim3 blockDim, void** args,
                                           size_t sharedBytes = 0, cudaStream_t stream = 0) {
    return ::cudaLaunchKernel((const void*)kernel, gridDim, blockDim, args, sharedBytes, stream);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaLaunchCooperativeKernel(T* kernel, dim3 gridDim, dim3 blockDim,
                                                      void** args, size_t sharedBytes = 0,
                                                      cudaStream_t stream = 0) {
    return ::cudaLaunchCooperativeKernel((const void*)kernel, gridDim, blockDim, args, sharedBytes,
                                         stream);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGetFuncBySymbol(cudaFunction_t* function, const T* symbol) {
    return ::cudaGetFuncBySymbol(function, (const void*)symbol);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaGetKernel(cudaKernel_t* handle, T* kernel) {
    return ::cudaGetKernel(handle, (const void*)kernel);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaFuncGetName(const char** name, T* kernel) {
    return ::cudaFuncGetName(name, (const void*)kernel);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(
    int* blocks, T* kernel, int blockSize, size_t sharedBytes, unsigned int flags) {
    return ::cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(
        blocks, (const void*)kernel, blockSize, sharedBytes, flags);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, T* kernel,
                                                                        int blockSize,
                                                                        size_t sharedBytes) {
    return ::cudaOccupancyMaxActiveBlocksPerMultiprocessor(blocks, (const void*)kernel, blockSize,
                                                           sharedBytes);
}

#if __cplusplus >= 201103L
template <class... Expected, class... Given>
SUNSTONE_HOST cudaError_t cudaLaunchKernelEx(const cudaLaunchConfig_t* config,
                                             void (*kernel)(Expected...), Given&&... given) {
    return [&](Expected... exact) {
        void* args[] = {(void*)&exact..., nullptr};
        return ::cudaLaunchKernelExC(config, (const void*)kernel, args);
    }(static_cast<Given&&>(given)...);
}
#endif

// The block size that keeps most threads of a multiprocessor busy, and the number of blocks that
// fill the device. sharedBytesOf gives the dynamic shared memory in bytes for a block size.
template <class Size, class T>
SUNSTONE_HOST cudaError_t cudaOccupancyMaxPotentialBlockSizeVariableSMemWithFlags(
    int* minGridSize, int* blockSize, T kernel, Size sharedBytesOf, int limit = 0,
    unsigned int flags = 0) {
    if (!minGridSize || !blockSize || !kernel)
        return cudaErrorInvalidValue;
    int device, warp, processors, threadsPerProcessor;
    cudaError_t error = ::cudaGetDevice(&device);
    if (!error)
        error = ::cudaDeviceGetAttribute(&warp, cudaDevAttrWarpSize, device);
    if (!error)
        error = ::cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device);
    if (!error)
        error = ::cudaDeviceGetAttribute(&threadsPerProcessor,
                                         cudaDevAttrMaxThreadsPerMultiProcessor, device);
    struct cudaFuncAttributes attributes;
    if (!error)
        error = ::cudaFuncGetAttributes(&attributes, (const void*)kernel);
    if (error)
        return error;
    int largest = attributes.maxThreadsPerBlock;
    if (limit > 0 && limit < largest)
        largest = limit;
    int bestThreads = 0, bestBlocks = 0, bestSize = 0;
    for (int size = (largest + warp - 1) / warp * warp; size > 0; size -= warp) {
        int tried = size < largest ? size : largest, blocks = 0;
        error = ::cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(
            &blocks, (const void*)kernel, tried, sharedBytesOf(tried), flags);
        if (error)
            return error;
        if (tried * blocks > bestThreads) {
            bestThreads = tried * blocks;
            bestBlocks = blocks;
            bestSize = tried;
        }
        if (bestThreads == threadsPerProcessor)
            break;
    }
    *minGridSize = bestBlocks * processors;
    *blockSize = bestSize;
    return cudaSuccess;
}
namespace sunstone_runtime {
struct ConstantSize {
    size_t bytes;
    __host__ __device__ size_t operator()(int) const { return bytes; }
};
} // namespace sunstone_runtime
template <class T>
SUNSTONE_HOST cudaError_t cudaOccupancyMaxPotentialBlockSize(int* minGridSize, int* blockSize,
                                                             T kernel, size_t sharedBytes = 0,
                                                             int limit = 0) {
    sunstone_runtime::ConstantSize size = {sharedBytes};
    return cudaOccupancyMaxPotentialBlockSizeVariableSMemWithFlags(minGridSize, blockSize, kernel,
                                                                   size, limit);
}

template <class Size, class T>
SUNSTONE_HOST cudaError_t cudaOccupancyMaxPotentialBlockSizeVariableSMem(int* minGridSize,
                                                                         int* blockSize, T kernel,
                                                                         Size sharedBytesOf,
                                                                         int limit = 0) {
    return cudaOccupancyMaxPotentialBlockSizeVariableSMemWithFlags(minGridSize, blockSize, kernel,
                                                                   sharedBytesOf, limit);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaOccupancyMaxPotentialBlockSizeWithFlags(
    int* minGridSize, int* blockSize, T kernel, size_t sharedBytes = 0, int limit = 0,
    unsigned int flags = 0) {
    sunstone_runtime::ConstantSize size = {sharedBytes};
    return cudaOccupancyMaxPotentialBlockSizeVariableSMemWithFlags(minGridSize, blockSize, kernel,
                                                                   size, limit, flags);
}
template <class T>
SUNSTONE_HOST cudaError_t cudaOccupancyAvailableDynamicSMemPerBlock(size_t* bytes, T* kernel,
                                                                    int blocks, int blockSize) {
    return ::cudaOccupancyAvailableDynamicSMemPerBlock(bytes, (const void*)kernel, blocks,
                                                       blockSize);
}

// An object that the graphs own and delete.
template <class T>
SUNSTONE_HOST cudaError_t cudaUserObjectCreate(cudaUserObject_t* object, T* owned,
                                               unsigned int references, unsigned int flags) {
    return ::cudaUserObjectCreate(
        object, owned, [](void* pointer) { delete static_cast<T*>(pointer); }, references, flags);
}

// The form of CUDA 11, with a node and a text that describe errors.
SUNSTONE_HOST cudaError_t cudaGraphInstantiate(cudaGraphExec_t* exec, cudaGraph_t graph,
                                               cudaGraphNode_t*, char*, size_t) {
    return ::cudaGraphInstantiate(exec, graph, 0);
}

#undef SUNSTONE_HOST

// ---- small constructors ------------------------------------------------------------------------
static __inline__ __host__ struct cudaPitchedPtr make_cudaPitchedPtr(void* ptr, size_t pitch,
                                                                     size_t xsize, size_t ysize) {
    struct cudaPitchedPtr p = {ptr, pitch, xsize, ysize};
    return p;
}
static __inline__ __host__ struct cudaExtent make_cudaExtent(size_t w, size_t h, size_t d) {
    struct cudaExtent e = {w, h, d};
    return e;
}
static __inline__ __host__ struct cudaPos make_cudaPos(size_t x, size_t y, size_t z) {
    struct cudaPos p = {x, y, z};
    return p;
}

#endif
#endif
