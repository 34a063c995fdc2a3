// SPDX-License-Identifier: Apache-2.0
// Embeds the PTX of the kernels (files of the build, named by macros) in the library.
#include "denoise/gpu/kernels_ptx.h"

#define SUNSTONE_TEXT(symbol, file)                                                                \
    asm(".pushsection .rodata\n" #symbol ":\n"                                                     \
        ".incbin \"" file "\"\n"                                                                   \
        ".byte 0\n"                                                                                \
        ".popsection\n");                                                                          \
    extern "C" __attribute__((visibility("hidden"))) const char symbol[];

SUNSTONE_TEXT(sunstone_denoiser_steps, SUNSTONE_STEP_KERNELS)
SUNSTONE_TEXT(sunstone_denoiser_filter_0, SUNSTONE_FILTER_KERNELS_0)
SUNSTONE_TEXT(sunstone_denoiser_filter_2, SUNSTONE_FILTER_KERNELS_2)
SUNSTONE_TEXT(sunstone_denoiser_filter_3, SUNSTONE_FILTER_KERNELS_3)
SUNSTONE_TEXT(sunstone_denoiser_filter_5, SUNSTONE_FILTER_KERNELS_5)
SUNSTONE_TEXT(sunstone_denoiser_filter_6, SUNSTONE_FILTER_KERNELS_6)

namespace sunstone::denoise::gpu {

const char* stepKernels() {
    return sunstone_denoiser_steps;
}

const char* filterKernels(int guides) {
    switch (guides) {
    case 0:
        return sunstone_denoiser_filter_0;
    case 2:
        return sunstone_denoiser_filter_2;
    case 3:
        return sunstone_denoiser_filter_3;
    case 5:
        return sunstone_denoiser_filter_5;
    case 6:
        return sunstone_denoiser_filter_6;
    default:
        return nullptr;
    }
}

} // namespace sunstone::denoise::gpu
