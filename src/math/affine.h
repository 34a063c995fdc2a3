// SPDX-License-Identifier: Apache-2.0
// 3x4 row-major affine transforms: the form of instances and pre-transforms.
#pragma once

#include "math/box.h"

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

// Computed in double precision. False, and zeros in `inverse`, if the matrix has no finite inverse.
inline bool invert(const float m[12], float inverse[12]) {
    const double a = m[0], b = m[1], c = m[2], d = m[4], e = m[5], f = m[6];
    const double g = m[8], h = m[9], i = m[10];
    const double c0 = e * i - f * h, c1 = f * g - d * i, c2 = d * h - e * g;
    const double det = a * c0 + b * c1 + c * c2;
    const double s = 1.0 / det;
    const double r[9] = {c0 * s, (c * h - b * i) * s, (b * f - c * e) * s,
                         c1 * s, (a * i - c * g) * s, (c * d - a * f) * s,
                         c2 * s, (b * g - a * h) * s, (a * e - b * d) * s};
    bool finite = det != 0;
    for (int row = 0; row < 3; ++row) {
        const double* q = r + 3 * row;
        const double t = -(q[0] * m[3] + q[1] * m[7] + q[2] * m[11]);
        const double out[4] = {q[0], q[1], q[2], t};
        for (int j = 0; j < 4; ++j) {
            inverse[4 * row + j] = float(out[j]);
            finite = finite && std::isfinite(inverse[4 * row + j]);
        }
    }
    if (!finite)
        for (int k = 0; k < 12; ++k)
            inverse[k] = 0;
    return finite;
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
