// SPDX-License-Identifier: Apache-2.0
// Memory pools: enumerations and structs equal the driver's.
#include "api/cuda/runtime/runtime.h"

using namespace sunstone::cudart;

static_assert(sizeof(cudaMemPoolProps) == sizeof(CUmemPoolProps));
static_assert(sizeof(cudaMemAccessDesc) == sizeof(CUmemAccessDesc));

namespace {

// Drivers older than pools lack the function.
template <class Function, class... Arguments>
cudaError_t callPool(Function Driver::*function, Arguments... arguments) {
    return call([&](const Driver& d) {
        return d.*function ? (d.*function)(arguments...) : CUDA_ERROR_NOT_SUPPORTED;
    });
}

} // namespace

SUNSTONE_CUDART cudaError_t cudaMemPoolCreate(cudaMemPool_t* pool,
                                              const struct cudaMemPoolProps* properties) {
    return callPool(&Driver::cuMemPoolCreate, pool,
                    reinterpret_cast<const CUmemPoolProps*>(properties));
}
SUNSTONE_CUDART cudaError_t cudaMemPoolDestroy(cudaMemPool_t pool) {
    return callPool(&Driver::cuMemPoolDestroy, pool);
}
SUNSTONE_CUDART cudaError_t cudaMemPoolTrimTo(cudaMemPool_t pool, size_t minBytesToKeep) {
    return callPool(&Driver::cuMemPoolTrimTo, pool, minBytesToKeep);
}
SUNSTONE_CUDART cudaError_t cudaMemPoolSetAttribute(cudaMemPool_t pool,
                                                    enum cudaMemPoolAttr attribute, void* value) {
    return callPool(&Driver::cuMemPoolSetAttribute, pool,
                    static_cast<CUmemPool_attribute>(attribute), value);
}
SUNSTONE_CUDART cudaError_t cudaMemPoolGetAttribute(cudaMemPool_t pool,
                                                    enum cudaMemPoolAttr attribute, void* value) {
    return callPool(&Driver::cuMemPoolGetAttribute, pool,
                    static_cast<CUmemPool_attribute>(attribute), value);
}
SUNSTONE_CUDART cudaError_t cudaMemPoolSetAccess(cudaMemPool_t pool,
                                                 const struct cudaMemAccessDesc* list,
                                                 size_t count) {
    return callPool(&Driver::cuMemPoolSetAccess, pool,
                    reinterpret_cast<const CUmemAccessDesc*>(list), count);
}
SUNSTONE_CUDART cudaError_t cudaMemPoolGetAccess(enum cudaMemAccessFlags* flags, cudaMemPool_t pool,
                                                 struct cudaMemLocation* location) {
    return callPool(&Driver::cuMemPoolGetAccess, reinterpret_cast<CUmemAccess_flags*>(flags), pool,
                    reinterpret_cast<CUmemLocation*>(location));
}
SUNSTONE_CUDART cudaError_t cudaDeviceGetDefaultMemPool(cudaMemPool_t* pool, int device) {
    return callPool(&Driver::cuDeviceGetDefaultMemPool, pool, device);
}
SUNSTONE_CUDART cudaError_t cudaDeviceGetMemPool(cudaMemPool_t* pool, int device) {
    return callPool(&Driver::cuDeviceGetMemPool, pool, device);
}
SUNSTONE_CUDART cudaError_t cudaDeviceSetMemPool(int device, cudaMemPool_t pool) {
    return callPool(&Driver::cuDeviceSetMemPool, device, pool);
}
