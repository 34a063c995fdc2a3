// SPDX-License-Identifier: Apache-2.0
// Ray queries for the avx2 instruction set; CMakeLists.txt sets the flags.
#include "bvh/walk/kernels_body.h"

namespace sunstone::bvh {

const Kernels kKernelsAvx2 = avx2::kAllKernels;

} // namespace sunstone::bvh
