// SPDX-License-Identifier: Apache-2.0
// The product of 3x4 row-major matrices, for CPUs and GPUs. Both targets compute the same bits.
#pragma once

#include "math/rounded.h"

namespace sunstone::math {

// Applies b, then a. `product` may be one of the two.
SUNSTONE_INLINE void multiply(const float a[12], const float b[12], float product[12]) {
    float result[12];
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) {
            float sum = column == 3 ? a[4 * row + 3] : 0.0f;
            for (int k = 0; k < 3; ++k)
                sum = add(sum, mul(a[4 * row + k], b[4 * k + column]));
            result[4 * row + column] = sum;
        }
    for (int i = 0; i < 12; ++i)
        product[i] = result[i];
}

} // namespace sunstone::math
