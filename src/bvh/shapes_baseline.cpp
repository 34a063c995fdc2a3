// SPDX-License-Identifier: Apache-2.0
// Curves and spheres for the baseline instruction set; CMakeLists.txt sets the flags.
#include "bvh/shapes_body.h"

namespace sunstone::bvh {

const ShapeKernels kShapesBaseline = {baseline::findShape<false>, baseline::findShape<true>, baseline::filterShapes};

} // namespace sunstone::bvh
