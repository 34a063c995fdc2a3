// SPDX-License-Identifier: Apache-2.0
// Ray queries for the avx512 instruction set; CMakeLists.txt sets the flags.
#include "bvh/kernels_body.h"

namespace sunstone::bvh {

const Kernels kKernelsAvx512 = {avx512::closest, avx512::occluded, avx512::meetsSide};

} // namespace sunstone::bvh
