// SPDX-License-Identifier: Apache-2.0
// Bounds of instances. The box around a turned box overhangs; boxes around the turned boxes of its
// parts overhang less, so the nodes below the child's root are turned one by one. Rays that pass
// between an instance and its box then need not enter it.
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

// Bounds of what the handle leads to, seen through a transform (rows, 3x4); empty if there is
// nothing that can be hit.
math::Box instanceBounds(const float transform[12], uint64_t handle, OpenLevels levels);

} // namespace sunstone::bvh
