// SPDX-License-Identifier: Apache-2.0
// optixTexFootprint2D and its variants. PTX has no instruction for them, but can query a texture's
// size.
#pragma once

#include "devlib/gpu/programs.h"
#include "texture/footprint_of_size.h"

namespace sunstone::devlib::gpu {

extern "C" void sunstone_footprint(uint64_t handle, uint32_t info, uint32_t form,
                                   const texture::SampleOperands* operands, uint32_t coarse,
                                   uint32_t* singleLevel, uint32_t result[4]) {
    uint32_t width, height;
    asm("txq.width.b32 %0, [%1];" : "=r"(width) : "l"(handle));
    asm("txq.height.b32 %0, [%1];" : "=r"(height) : "l"(handle));
    // Coordinates count as normalised, like those of mipmapped textures: drivers up to 580 compile
    // txq.normalized_coords, but do not find kernels that contain it.
    texture::footprintOfSize(width, height, true, info, form, operands, coarse,
                             singleLevel, result);
}

} // namespace sunstone::devlib::gpu
