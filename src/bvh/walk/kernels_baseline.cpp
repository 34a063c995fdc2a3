// SPDX-License-Identifier: Apache-2.0
// Ray queries for the baseline instruction set; CMakeLists.txt sets the flags.
#include "bvh/walk/kernels_body.h"

namespace sunstone::bvh {

const Kernels kKernelsBaseline = baseline::kAllKernels;

} // namespace sunstone::bvh
