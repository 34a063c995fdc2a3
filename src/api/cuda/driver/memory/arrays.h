// SPDX-License-Identifier: Apache-2.0
// CUDA arrays and mipmapped arrays of the driver API: handles of the arrays in src/texture.
#pragma once

#include "api/cuda/driver/shell.h"
#include "base/handles.h"
#include "texture/texture.h"

#include <memory>

namespace sunstone::api::cuda {

struct ArrayHandle : Handled {
    std::shared_ptr<texture::Array> array;
    CUDA_ARRAY3D_DESCRIPTOR descriptor = {};
    const void* owner = nullptr; // context
    bool isLevel = false;        // of a mipmapped array, which owns it
};

struct MipmapHandle {
    std::vector<std::shared_ptr<ArrayHandle>> levels;
    const void* owner = nullptr;
};

// The live object of a handle; throws CUDA_ERROR_INVALID_HANDLE.
std::shared_ptr<ArrayHandle> arrayOf(CUarray array);
std::shared_ptr<MipmapHandle> mipmapOf(CUmipmappedArray mipmap);

// Throws CUDA_ERROR_INVALID_VALUE for unknown formats, CUDA_ERROR_NOT_SUPPORTED for formats without
// a decoder.
texture::Format formatOf(CUarray_format format, unsigned channels);

} // namespace sunstone::api::cuda
