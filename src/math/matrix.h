// SPDX-License-Identifier: Apache-2.0
// 3x4 row-major matrices, for CPUs and GPUs: the inverse, and the product of an SRT motion key.
// Both targets compute the same bits.
#pragma once

#include "math/rounded.h"

#include <cstdint>

namespace sunstone::math {

// Computed in double precision. False, and zeros in `inverse`, if the matrix has no finite inverse.
SUNSTONE_INLINE bool invert(const float m[12], float inverse[12]) {
    const double a = m[0], b = m[1], c = m[2], d = m[4], e = m[5], f = m[6];
    const double g = m[8], h = m[9], i = m[10];
    const double c0 = sub(mul(e, i), mul(f, h)), c1 = sub(mul(f, g), mul(d, i)),
                 c2 = sub(mul(d, h), mul(e, g));
    const double det = add(add(mul(a, c0), mul(b, c1)), mul(c, c2));
    const double s = 1.0 / det;
    const double r[9] = {
        mul(c0, s), mul(sub(mul(c, h), mul(b, i)), s), mul(sub(mul(b, f), mul(c, e)), s),
        mul(c1, s), mul(sub(mul(a, i), mul(c, g)), s), mul(sub(mul(c, d), mul(a, f)), s),
        mul(c2, s), mul(sub(mul(b, g), mul(a, h)), s), mul(sub(mul(a, e), mul(b, d)), s)};
    bool finite = det != 0;
    for (int row = 0; row < 3; ++row) {
        const double* const q = r + 3 * row;
        const double t =
            -add(add(mul(q[0], double(m[3])), mul(q[1], double(m[7]))), mul(q[2], double(m[11])));
        for (int j = 0; j < 4; ++j) {
            const float value = float(j < 3 ? q[j] : t);
            inverse[4 * row + j] = value;
            finite = finite && (__builtin_bit_cast(uint32_t, value) & 0x7F800000u) != 0x7F800000u;
        }
    }
    if (!finite)
        for (int k = 0; k < 12; ++k)
            inverse[k] = 0;
    return finite;
}

// T * R * S of an SRT key with a normalised quaternion. The numbers of `k`, in the order of
// OptixSRTData: sx a b pvx sy c pvy sz pvz qx qy qz qw tx ty tz.
SUNSTONE_INLINE void multiplySrt(const float k[16], float m[12]) {
    const float qx = k[9], qy = k[10], qz = k[11], qw = k[12];
    const float xx = mul(qx, qx), yy = mul(qy, qy), zz = mul(qz, qz), ww = mul(qw, qw);
    const float xy = mul(qx, qy), xz = mul(qx, qz), yz = mul(qy, qz);
    const float wx = mul(qw, qx), wy = mul(qw, qy), wz = mul(qw, qz);
    const float r[12] = {sub(sub(add(ww, xx), yy), zz),
                         2 * sub(xy, wz),
                         2 * add(xz, wy),
                         k[13],
                         2 * add(xy, wz),
                         sub(add(sub(ww, xx), yy), zz),
                         2 * sub(yz, wx),
                         k[14],
                         2 * sub(xz, wy),
                         2 * add(yz, wx),
                         add(sub(sub(ww, xx), yy), zz),
                         k[15]};
    const float s[12] = {k[0], k[1], k[2], k[3], 0, k[4], k[5], k[6], 0, 0, k[7], k[8]};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j)
            m[4 * i + j] = add(add(add(mul(r[4 * i], s[j]), mul(r[4 * i + 1], s[4 + j])),
                                   mul(r[4 * i + 2], s[8 + j])),
                               j == 3 ? r[4 * i + 3] : 0.0f);
}

} // namespace sunstone::math
