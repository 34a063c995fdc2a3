// SPDX-License-Identifier: Apache-2.0
// Channel descriptions and array handles of the runtime API in terms of the driver's.
#pragma once

#include "api/cuda/runtime/runtime.h"

namespace sunstone::cudart {

// False for descriptions without a matching format.
bool toFormat(const cudaChannelFormatDesc& desc, CUarray_format* format, unsigned* channels);
cudaChannelFormatDesc toChannelDesc(CUarray_format format, unsigned channels);

// Runtime handles equal the driver's.
inline CUarray arrayOf(cudaArray_const_t array) {
    return reinterpret_cast<CUarray>(const_cast<cudaArray*>(array));
}
inline CUmipmappedArray mipmapOf(cudaMipmappedArray_const_t mipmap) {
    return reinterpret_cast<CUmipmappedArray>(const_cast<cudaMipmappedArray*>(mipmap));
}

// The unit of a copy along x and y of an array: texels, or blocks of 4 x 4.
struct Element {
    size_t bytes = 1;
    size_t edge = 1;
};
CUresult elementOf(const Driver& driver, cudaArray_const_t array, Element* element);

CUmemorytype typeOf(cudaMemcpyKind kind, bool destination);
// The driver's description of a copy. Requires a current context.
cudaError_t toDriver(const cudaMemcpy3DParms& parms, CUDA_MEMCPY3D* copy);

// Layouts used by compiled applications.
static_assert(sizeof(cudaResourceDesc) == 144 && sizeof(cudaTextureDesc) == 72 &&
              sizeof(cudaResourceViewDesc) == 112);

} // namespace sunstone::cudart
