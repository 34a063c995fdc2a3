// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes. A fresh Box is empty: lower = +inf, upper = -inf.
#pragma once

#include "math/vec3.h"

#include <algorithm>
#include <limits>

namespace sunstone::math {

struct Box {
    static constexpr float kInf = std::numeric_limits<float>::infinity();
    Vec3 lower{kInf, kInf, kInf};
    Vec3 upper{-kInf, -kInf, -kInf};

    bool empty() const {
        return !(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z);
    }
    void extend(Vec3 p) {
        lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
        upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
    }
    void extend(const Box& b) {
        lower = {std::min(lower.x, b.lower.x), std::min(lower.y, b.lower.y),
                 std::min(lower.z, b.lower.z)};
        upper = {std::max(upper.x, b.upper.x), std::max(upper.y, b.upper.y),
                 std::max(upper.z, b.upper.z)};
    }
};

// Half the surface area; 0 for an empty box.
inline float halfArea(const Box& b) {
    if (b.empty())
        return 0;
    Vec3 d = b.upper - b.lower;
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

} // namespace sunstone::math
