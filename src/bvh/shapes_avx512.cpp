// SPDX-License-Identifier: Apache-2.0
// Curves and spheres for the avx512 instruction set; CMakeLists.txt sets the flags.
#include "bvh/shapes_body.h"

namespace sunstone::bvh {

const ShapeKernels kShapesAvx512 = {avx512::findShape<false>, avx512::findShape<true>, avx512::filterShapes};

} // namespace sunstone::bvh
