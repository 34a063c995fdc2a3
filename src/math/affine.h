// SPDX-License-Identifier: Apache-2.0
// 3x4 row-major affine transforms: the form of instances and pre-transforms.
#pragma once

#include "math/box.h"
#include "math/matrix.h"

#include <cmath>

namespace sunstone::math {

struct Affine {
    float m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
};

inline Vec3 transformPoint(const float m[12], Vec3 p) {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
            m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

inline Vec3 transformVector(const float m[12], Vec3 v) {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
            m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

// The product: applies b, then a.
inline Affine multiply(const float a[12], const float b[12]) {
    Affine c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j)
            c.m[4 * i + j] = a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j] +
                             (j == 3 ? a[4 * i + 3] : 0.0f);
    return c;
}

// Bounds of a transformed box, with a margin for the rounding of later ray transforms.
inline Box transformBox(const float m[12], const Box& b) {
    Box r;
    if (b.empty())
        return r;
    for (int i = 0; i < 3; ++i) {
        double lo = m[4 * i + 3], hi = lo, magnitude = std::fabs(lo);
        for (int j = 0; j < 3; ++j) {
            const double p = double(m[4 * i + j]) * b.lower[j];
            const double q = double(m[4 * i + j]) * b.upper[j];
            lo += std::min(p, q);
            hi += std::max(p, q);
            magnitude += std::max(std::fabs(p), std::fabs(q));
        }
        const double margin = magnitude * 0x1p-20;
        r.lower[i] = float(lo - margin);
        r.upper[i] = float(hi + margin);
    }
    return r;
}

} // namespace sunstone::math
