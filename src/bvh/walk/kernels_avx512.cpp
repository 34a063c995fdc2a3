// SPDX-License-Identifier: Apache-2.0
// Ray queries for the avx512 instruction set; CMakeLists.txt sets the flags.
#include "bvh/walk/kernels_body.h"

namespace sunstone::bvh {

const Kernels kKernelsAvx512 = avx512::kAllKernels;

} // namespace sunstone::bvh
