// SPDX-License-Identifier: Apache-2.0
// Curves and spheres for the avx2 instruction set; CMakeLists.txt sets the flags.
#include "bvh/shapes/shapes_body.h"

namespace sunstone::bvh::avx2 {

extern const ShapeKernels kShapes = {findShape<false>, findShape<true>, filterShapes};

} // namespace sunstone::bvh::avx2
