// SPDX-License-Identifier: Apache-2.0
// Embeds the PTX of kernels.cu (SUNSTONE_BUILDER_PTX, a file of the build) in the library.
#include "bvh/gpu/kernels_ptx.h"

asm(".pushsection .rodata\n"
    "sunstone_builder_ptx:\n"
    ".incbin \"" SUNSTONE_BUILDER_PTX "\"\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" __attribute__((visibility("hidden"))) const char sunstone_builder_ptx[];

namespace sunstone::bvh::gpu {

const char* builderPtx() {
    return sunstone_builder_ptx;
}

} // namespace sunstone::bvh::gpu
