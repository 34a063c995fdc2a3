// SPDX-License-Identifier: Apache-2.0
// Curves and spheres for the avx2 instruction set; CMakeLists.txt sets the flags.
#include "bvh/shapes_body.h"

namespace sunstone::bvh {

const ShapeKernels kShapesAvx2 = {avx2::findShape<false>, avx2::findShape<true>, avx2::filterShapes};

} // namespace sunstone::bvh
