// SPDX-License-Identifier: Apache-2.0
// Curves and spheres for the baseline instruction set; CMakeLists.txt sets the flags.
#include "bvh/shapes/shapes_body.h"

namespace sunstone::bvh::baseline {

extern const ShapeKernels kShapes = {findShape<false>, findShape<true>, filterShapes};

} // namespace sunstone::bvh::baseline
