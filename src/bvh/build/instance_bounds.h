// SPDX-License-Identifier: Apache-2.0
// Bounds of instances. The axis-aligned box of a rotated box is larger than the geometry needs; the
// boxes of its rotated parts are tighter. The bounds therefore unite the transformed boxes of nodes
// below the child's root, so that fewer rays enter an instance without a hit.
#pragma once

#include "bvh/layout.h"
#include "math/box.h"

namespace sunstone::bvh {

// The number of levels of the child's tree that the bounds use.
struct OpenLevels {
    unsigned count;
    static OpenLevels of(uint32_t options) { // OptionBit
        return {options & kOptionFastBuild ? 0u : options & kOptionFastTrace ? 3u : 2u};
    }
};

// Bounds of the handle's object through a transform (rows, 3x4); empty if no primitive can be hit.
math::Box instanceBounds(const float transform[12], uint64_t handle, OpenLevels levels);

} // namespace sunstone::bvh
