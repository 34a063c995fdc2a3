// SPDX-License-Identifier: Apache-2.0
// Bounds of instances. The axis-aligned box of a rotated box is larger than the geometry inside
// needs; the boxes of its rotated parts are tighter. The nodes below the child's root are therefore
// transformed one by one, so that rays that only graze an instance do not enter it.
#pragma once

#include "bvh/layout.h"
#include "math/box.h"

namespace sunstone::bvh {

// How many levels of the child's tree are looked at.
struct OpenLevels {
    unsigned count;
    static OpenLevels of(uint32_t options) { // OptionBit
        return {options & kOptionFastBuild ? 0u : options & kOptionFastTrace ? 3u : 2u};
    }
};

// Bounds of the handle's object through a transform (rows, 3x4); empty if no primitive can be hit.
math::Box instanceBounds(const float transform[12], uint64_t handle, OpenLevels levels);

} // namespace sunstone::bvh
