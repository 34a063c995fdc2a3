// SPDX-License-Identifier: Apache-2.0
// CUDA arrays and mipmapped arrays of the driver API: handles around the texture part's arrays.
#pragma once

#include "api/cuda/driver/shell.h"
#include "texture/texture.h"

#include <memory>

namespace sunstone::api::cuda {

struct ArrayHandle {
    std::shared_ptr<texture::Array> array;
    CUDA_ARRAY3D_DESCRIPTOR descriptor = {};
    const void* owner = nullptr; // context
    bool isLevel = false;        // of a mipmapped array, which frees it

    ~ArrayHandle();
};

struct MipmapHandle {
    std::vector<std::shared_ptr<ArrayHandle>> levels;
    const void* owner = nullptr;
};

// The live object of a handle, or CUDA_ERROR_INVALID_HANDLE.
std::shared_ptr<ArrayHandle> arrayOf(CUarray array);
std::shared_ptr<MipmapHandle> mipmapOf(CUmipmappedArray mipmap);

// Throws for formats that are unknown (CUDA_ERROR_INVALID_VALUE) or not decoded here
// (CUDA_ERROR_NOT_SUPPORTED).
texture::Format formatOf(CUarray_format format, unsigned channels);

} // namespace sunstone::api::cuda
