// SPDX-License-Identifier: Apache-2.0
// Kernels: attributes, occupancy, and the launch configuration that <<<>>> pushes for the stub.
#include "api/cuda/runtime/runtime.h"

#include "base/threads/thread_object.h"

#include <cstring>
#include <vector>

using namespace sunstone::cudart;

namespace {

struct Configuration {
    dim3 grid, block;
    size_t sharedBytes = 0;
    cudaStream_t stream = nullptr;
    std::vector<unsigned char> arguments; // of cudaSetupArgument, older protocol
    std::vector<size_t> offsets;
};
std::vector<Configuration>& configurations() {
    return sunstone::threadObject<std::vector<Configuration>>();
}

template <class Body>
cudaError_t withFunction(const void* symbol, Body&& body) {
    return call([&](const Driver& d) {
        CUfunction function = nullptr;
        const cudaError_t error = findFunction(symbol, &function);
        return error ? error : fromDriver(body(d, function));
    });
}

} // namespace

SUNSTONE_CUDART unsigned int __cudaPushCallConfiguration(dim3 gridDim, dim3 blockDim,
                                                         size_t sharedBytes,
                                                         struct CUstream_st* stream) {
    configurations().push_back({gridDim, blockDim, sharedBytes, stream, {}, {}});
    return 0;
}
SUNSTONE_CUDART cudaError_t __cudaPopCallConfiguration(dim3* gridDim, dim3* blockDim,
                                                       size_t* sharedBytes, void* stream) {
    if (configurations().empty())
        return remember(cudaErrorMissingConfiguration);
    const Configuration& top = configurations().back();
    *gridDim = top.grid;
    *blockDim = top.block;
    *sharedBytes = top.sharedBytes;
    *static_cast<cudaStream_t*>(stream) = top.stream;
    configurations().pop_back();
    return cudaSuccess;
}

SUNSTONE_CUDART cudaError_t cudaConfigureCall(dim3 gridDim, dim3 blockDim, size_t sharedBytes,
                                              cudaStream_t stream) {
    configurations().push_back({gridDim, blockDim, sharedBytes, stream, {}, {}});
    return cudaSuccess;
}
SUNSTONE_CUDART cudaError_t cudaSetupArgument(const void* argument, size_t size, size_t offset) {
    constexpr size_t kMostBytes = 32764;
    if (configurations().empty())
        return remember(cudaErrorMissingConfiguration);
    if (!argument || size > kMostBytes || offset > kMostBytes - size)
        return remember(cudaErrorInvalidValue);
    Configuration& top = configurations().back();
    if (top.arguments.size() < offset + size)
        top.arguments.resize(offset + size);
    std::memcpy(top.arguments.data() + offset, argument, size);
    top.offsets.push_back(offset);
    return cudaSuccess;
}
SUNSTONE_CUDART cudaError_t cudaLaunch(const void* hostFunction) {
    if (configurations().empty())
        return remember(cudaErrorMissingConfiguration);
    Configuration top = std::move(configurations().back());
    configurations().pop_back();
    std::vector<void*> args;
    for (size_t offset : top.offsets)
        args.push_back(top.arguments.data() + offset);
    args.push_back(nullptr);
    return cudaLaunchKernel(hostFunction, top.grid, top.block, args.data(), top.sharedBytes,
                            top.stream);
}

SUNSTONE_CUDART cudaError_t cudaFuncGetName(const char** name, const void* function) {
    if (!name)
        return remember(cudaErrorInvalidValue);
    return withFunction(function, [&](const Driver& d, CUfunction found) {
        return d.cuFuncGetName ? d.cuFuncGetName(name, found) : CUDA_ERROR_NOT_SUPPORTED;
    });
}
SUNSTONE_CUDART cudaError_t cudaFuncGetParamInfo(const void* function, size_t index, size_t* offset,
                                                 size_t* size) {
    return withFunction(function, [&](const Driver& d, CUfunction found) {
        return d.cuFuncGetParamInfo ? d.cuFuncGetParamInfo(found, index, offset, size)
                                    : CUDA_ERROR_NOT_SUPPORTED;
    });
}
SUNSTONE_CUDART cudaError_t cudaFuncGetAttributes(struct cudaFuncAttributes* attributes,
                                                  const void* function) {
    if (!attributes)
        return remember(cudaErrorInvalidValue);
    return withFunction(function, [&](const Driver& d, CUfunction found) {
        cudaFuncAttributes result = {};
        CUresult error = CUDA_SUCCESS;
        auto get = [&](CUfunction_attribute attribute) {
            int value = 0;
            if (!error)
                error = d.cuFuncGetAttribute(&value, attribute, found);
            return value;
        };
        result.sharedSizeBytes = static_cast<size_t>(get(CU_FUNC_ATTRIBUTE_SHARED_SIZE_BYTES));
        result.constSizeBytes = static_cast<size_t>(get(CU_FUNC_ATTRIBUTE_CONST_SIZE_BYTES));
        result.localSizeBytes = static_cast<size_t>(get(CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES));
        result.maxThreadsPerBlock = get(CU_FUNC_ATTRIBUTE_MAX_THREADS_PER_BLOCK);
        result.numRegs = get(CU_FUNC_ATTRIBUTE_NUM_REGS);
        result.ptxVersion = get(CU_FUNC_ATTRIBUTE_PTX_VERSION);
        result.binaryVersion = get(CU_FUNC_ATTRIBUTE_BINARY_VERSION);
        result.cacheModeCA = get(CU_FUNC_ATTRIBUTE_CACHE_MODE_CA);
        result.maxDynamicSharedSizeBytes = get(CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES);
        result.preferredShmemCarveout = get(CU_FUNC_ATTRIBUTE_PREFERRED_SHARED_MEMORY_CARVEOUT);
        if (!error)
            *attributes = result;
        return error;
    });
}
SUNSTONE_CUDART cudaError_t cudaFuncSetAttribute(const void* function,
                                                 enum cudaFuncAttribute attribute, int value) {
    return withFunction(function, [&](const Driver& d, CUfunction found) {
        return d.cuFuncSetAttribute(found, static_cast<CUfunction_attribute>(attribute), value);
    });
}
SUNSTONE_CUDART cudaError_t cudaFuncSetCacheConfig(const void* function,
                                                   enum cudaFuncCache config) {
    return withFunction(function, [&](const Driver& d, CUfunction found) {
        return d.cuFuncSetCacheConfig(found, static_cast<CUfunc_cache>(config));
    });
}
SUNSTONE_CUDART cudaError_t cudaFuncSetSharedMemConfig(const void* function,
                                                       enum cudaSharedMemConfig config) {
    return withFunction(function, [&](const Driver& d, CUfunction found) {
        return d.cuFuncSetSharedMemConfig
                   ? d.cuFuncSetSharedMemConfig(found, static_cast<CUsharedconfig>(config))
                   : CUDA_ERROR_NOT_SUPPORTED;
    });
}
SUNSTONE_CUDART cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(
    int* blocks, const void* function, int blockSize, size_t sharedBytes, unsigned int flags) {
    return withFunction(function, [&](const Driver& d, CUfunction found) {
        return d.cuOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(blocks, found, blockSize,
                                                                      sharedBytes, flags);
    });
}
SUNSTONE_CUDART cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks,
                                                                          const void* function,
                                                                          int blockSize,
                                                                          size_t sharedBytes) {
    return cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(blocks, function, blockSize,
                                                                  sharedBytes, 0);
}
SUNSTONE_CUDART cudaError_t cudaOccupancyAvailableDynamicSMemPerBlock(size_t* bytes,
                                                                      const void* function,
                                                                      int blocks, int blockSize) {
    return withFunction(function, [&](const Driver& d, CUfunction found) {
        return d.cuOccupancyAvailableDynamicSMemPerBlock(bytes, found, blocks, blockSize);
    });
}
