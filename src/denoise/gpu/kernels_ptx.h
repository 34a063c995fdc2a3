// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sunstone::denoise::gpu {

// Kernels as PTX text, compiled with the library: those of step_kernels.cu, and of
// filter_kernels.cu for 0, 2, 3, 5 or 6 planes of guides.
const char* stepKernels();
const char* filterKernels(int guides);

} // namespace sunstone::denoise::gpu
