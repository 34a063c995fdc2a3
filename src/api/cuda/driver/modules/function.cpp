// SPDX-License-Identifier: Apache-2.0
// Function attributes and occupancy.
#include "api/cuda/driver/launch.h"

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace sunstone::api::cuda {

int attributeOf(Function& function, CUfunction_attribute attribute) {
    if (attribute == CU_FUNC_ATTRIBUTE_SHARED_SIZE_BYTES ||
        attribute == CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES ||
        attribute == CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES)
        ensureCompiled(function);
    std::shared_ptr<Module> module = function.module.lock();
    switch (int(attribute)) {
    case CU_FUNC_ATTRIBUTE_MAX_THREADS_PER_BLOCK:
        return int(maxThreadsOf(function));
    case CU_FUNC_ATTRIBUTE_SHARED_SIZE_BYTES:
        return int(function.info->staticSharedBytes);
    case CU_FUNC_ATTRIBUTE_CONST_SIZE_BYTES:
        return 0;
    case CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES:
        return int(function.info->localBytes);
    case CU_FUNC_ATTRIBUTE_NUM_REGS:
        return 32; // never the limit of a launch here
    case CU_FUNC_ATTRIBUTE_PTX_VERSION:
        return module ? module->ptxVersion() : 0;
    case CU_FUNC_ATTRIBUTE_BINARY_VERSION:
        return kMajor * 10 + kMinor;
    case CU_FUNC_ATTRIBUTE_CACHE_MODE_CA:
        return 0;
    case CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES:
        return int(maxDynamicSharedOf(function));
    case CU_FUNC_ATTRIBUTE_PREFERRED_SHARED_MEMORY_CARVEOUT:
        return function.carveout;
    default:
        if (int(attribute) < 0 || attribute >= CU_FUNC_ATTRIBUTE_MAX)
            refuse(CUDA_ERROR_INVALID_VALUE, "there is no function attribute ", int(attribute));
        return 0; // clusters: not required, not set
    }
}

void setAttribute(Function& function, CUfunction_attribute attribute, int value) {
    if (attribute == CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES) {
        ensureCompiled(function);
        if (value < 0 || unsigned(value) + function.info->staticSharedBytes > kSharedOptin)
            refuse(CUDA_ERROR_INVALID_VALUE, value, " bytes of dynamic shared memory; with ",
                   function.info->staticSharedBytes, " static ones at most ", kSharedOptin);
        function.maxDynamicShared = unsigned(value);
    } else if (attribute == CU_FUNC_ATTRIBUTE_PREFERRED_SHARED_MEMORY_CARVEOUT) {
        require(value >= -1 && value <= 100, "the carve-out is a percentage");
        function.carveout = value;
    } else {
        refuse(CUDA_ERROR_INVALID_VALUE, "function attribute ", int(attribute), " cannot be set");
    }
}

} // namespace sunstone::api::cuda

namespace {

void potentialBlockSize(int* minGridSize, int* blockSize, const Function& function,
                        CUoccupancyB2DSize sharedBytesOf, size_t sharedBytes, int limit) {
    int device = 0, processors = 0;
    cuDeviceGetAttribute(&processors, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT, device);
    unsigned largest = maxThreadsOf(function);
    if (limit > 0)
        largest = std::min(largest, unsigned(limit));
    unsigned bestThreads = 0, bestBlocks = 0, bestSize = 0;
    for (unsigned size = (largest + kWarpSize - 1) / kWarpSize * kWarpSize; size > 0;
         size -= kWarpSize) {
        const unsigned tried = std::min(size, largest);
        const size_t shared = sharedBytesOf ? sharedBytesOf(int(tried)) : sharedBytes;
        const unsigned blocks = activeBlocks(function, tried, shared);
        if (blocks * tried > bestThreads) {
            bestThreads = blocks * tried;
            bestBlocks = blocks;
            bestSize = tried;
        }
    }
    if (bestSize == 0)
        refuse(CUDA_ERROR_INVALID_VALUE, "no block size fits with ", sharedBytes,
               " bytes of shared memory");
    *minGridSize = int(bestBlocks) * processors;
    *blockSize = int(bestSize);
}

} // namespace

SUNSTONE_EXPORT CUresult cuFuncGetAttribute(int* value, CUfunction_attribute attribute,
                                            CUfunction function) {
    return guarded("cuFuncGetAttribute", Needs::kObject, [&] {
        require(value, "value is null");
        *value = attributeOf(*liveFunctionOf(function), attribute);
    });
}
SUNSTONE_EXPORT CUresult cuFuncSetAttribute(CUfunction function, CUfunction_attribute attribute,
                                            int value) {
    return guarded("cuFuncSetAttribute", Needs::kObject,
                   [&] { setAttribute(*liveFunctionOf(function), attribute, value); });
}
SUNSTONE_EXPORT CUresult cuFuncSetCacheConfig(CUfunction function, CUfunc_cache config) {
    return guarded("cuFuncSetCacheConfig", Needs::kObject, [&] {
        liveFunctionOf(function);
        require(unsigned(config) <= CU_FUNC_CACHE_PREFER_EQUAL, "unknown cache configuration");
    });
}
SUNSTONE_EXPORT CUresult cuFuncSetSharedMemConfig(CUfunction function, CUsharedconfig config) {
    return guarded("cuFuncSetSharedMemConfig", Needs::kObject, [&] {
        liveFunctionOf(function);
        require(unsigned(config) <= CU_SHARED_MEM_CONFIG_EIGHT_BYTE_BANK_SIZE,
                "unknown shared memory configuration");
    });
}
SUNSTONE_EXPORT CUresult cuFuncGetModule(CUmodule* module, CUfunction function) {
    return guarded("cuFuncGetModule", Needs::kObject, [&] {
        require(module, "module is null");
        *module = static_cast<CUmodule>(handleOrNull(liveFunctionOf(function)->module.lock()));
    });
}
SUNSTONE_EXPORT CUresult cuFuncGetName(const char** name, CUfunction function) {
    return guarded("cuFuncGetName", Needs::kObject, [&] {
        require(name, "name is null");
        *name = liveFunctionOf(function)->name.c_str();
    });
}
SUNSTONE_EXPORT CUresult cuFuncGetParamInfo(CUfunction function, size_t index, size_t* offset,
                                            size_t* size) {
    return guarded("cuFuncGetParamInfo", Needs::kObject, [&] {
        require(offset, "offset is null");
        std::shared_ptr<Function> found = liveFunctionOf(function);
        const compiler::KernelInfo& info = *found->info;
        if (index >= info.parameterOffsets.size())
            refuse(CUDA_ERROR_INVALID_VALUE, "the kernel has ", info.parameterOffsets.size(),
                   " parameters");
        *offset = info.parameterOffsets[index];
        if (size)
            *size = info.parameterSizes[index];
    });
}

SUNSTONE_EXPORT CUresult cuModuleGetLoadingMode(CUmoduleLoadingMode* mode) {
    return guarded("cuModuleGetLoadingMode", Needs::kInit, [&] {
        require(mode, "mode is null");
        *mode = CU_MODULE_LAZY_LOADING;
    });
}
SUNSTONE_EXPORT CUresult cuFuncIsLoaded(CUfunctionLoadingState* state, CUfunction function) {
    return guarded("cuFuncIsLoaded", Needs::kObject, [&] {
        require(state, "state is null");
        *state = liveFunctionOf(function)->compiled.load(std::memory_order_acquire)
                     ? CU_FUNCTION_LOADING_STATE_LOADED
                     : CU_FUNCTION_LOADING_STATE_UNLOADED;
    });
}
SUNSTONE_EXPORT CUresult cuFuncLoad(CUfunction function) {
    return guarded("cuFuncLoad", Needs::kObject, [&] { functionOf(function); });
}

SUNSTONE_EXPORT CUresult cuOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(
    int* blocks, CUfunction function, int blockSize, size_t sharedBytes, unsigned int flags) {
    return guarded("cuOccupancyMaxActiveBlocksPerMultiprocessor", Needs::kContext, [&] {
        require(blocks && blockSize > 0 && flags <= CU_OCCUPANCY_DISABLE_CACHING_OVERRIDE,
                "blocks is null, the block size not positive, or unknown flags");
        *blocks = int(activeBlocks(*functionOf(function), unsigned(blockSize), sharedBytes));
    });
}
SUNSTONE_EXPORT CUresult cuOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks,
                                                                     CUfunction function,
                                                                     int blockSize,
                                                                     size_t sharedBytes) {
    return cuOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(blocks, function, blockSize,
                                                                sharedBytes, 0);
}
SUNSTONE_EXPORT CUresult cuOccupancyMaxPotentialBlockSizeWithFlags(
    int* minGridSize, int* blockSize, CUfunction function, CUoccupancyB2DSize sharedBytesOf,
    size_t sharedBytes, int blockSizeLimit, unsigned int flags) {
    return guarded("cuOccupancyMaxPotentialBlockSize", Needs::kContext, [&] {
        require(minGridSize && blockSize && flags <= CU_OCCUPANCY_DISABLE_CACHING_OVERRIDE,
                "minGridSize or blockSize is null, or unknown flags");
        potentialBlockSize(minGridSize, blockSize, *functionOf(function), sharedBytesOf,
                           sharedBytes, blockSizeLimit);
    });
}
SUNSTONE_EXPORT CUresult cuOccupancyMaxPotentialBlockSize(int* minGridSize, int* blockSize,
                                                          CUfunction function,
                                                          CUoccupancyB2DSize sharedBytesOf,
                                                          size_t sharedBytes, int blockSizeLimit) {
    return cuOccupancyMaxPotentialBlockSizeWithFlags(minGridSize, blockSize, function,
                                                     sharedBytesOf, sharedBytes, blockSizeLimit, 0);
}
SUNSTONE_EXPORT CUresult cuOccupancyAvailableDynamicSMemPerBlock(size_t* bytes, CUfunction function,
                                                                 int blocks, int blockSize) {
    return guarded("cuOccupancyAvailableDynamicSMemPerBlock", Needs::kContext, [&] {
        require(bytes && blocks > 0 && blockSize > 0, "bytes is null or a size is not positive");
        std::shared_ptr<Function> found = functionOf(function);
        const size_t share = kSharedPerProcessor / size_t(blocks);
        const size_t statics = found->info->staticSharedBytes;
        *bytes =
            share > statics ? std::min<size_t>(share - statics, maxDynamicSharedOf(*found)) : 0;
    });
}
