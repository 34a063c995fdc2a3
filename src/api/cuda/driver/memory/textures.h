// SPDX-License-Identifier: Apache-2.0
// Makes texture and surface objects from descriptions, for objects and references.
#pragma once

#include "api/cuda/driver/memory/arrays.h"

namespace sunstone::api::cuda {

uint64_t createTexture(const CUDA_RESOURCE_DESC& resource, const CUDA_TEXTURE_DESC& description,
                       const CUDA_RESOURCE_VIEW_DESC* view);
uint64_t createSurface(const CUDA_RESOURCE_DESC& resource);

// Layouts used by compiled applications.
static_assert(sizeof(CUDA_ARRAY3D_DESCRIPTOR) == 40 && sizeof(CUDA_RESOURCE_DESC) == 144 &&
              sizeof(CUDA_TEXTURE_DESC) == 104 && sizeof(CUDA_RESOURCE_VIEW_DESC) == 112);

} // namespace sunstone::api::cuda
