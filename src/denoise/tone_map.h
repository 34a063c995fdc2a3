// SPDX-License-Identifier: Apache-2.0
// A tone curve: exposure, then a power. Compiled for CPUs and for threads of GPUs with the same
// bits as the result; nothing here may be fused.
#pragma once

#include "denoise/logarithm.h"

namespace sunstone::denoise {

// `value` to the power of `exponent`, for values in (0, 1] and exponents above 0, to some 1e-9 of
// itself. Series are short, and coefficients constant: logarithm() and exponential() are for single
// values of an image, this is for each of its pixels.
inline float powerOf(float value, float exponent) {
    const uint64_t bits = std::bit_cast<uint64_t>(double(value));
    int binary = int(bits >> 52) - 1023;
    double m = std::bit_cast<double>((bits & 0xFFFFFFFFFFFFFull) | 0x3FF0000000000000ull);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        ++binary;
    }
    // ln m = 2 (s + s^3/3 + s^5/5 ...) with |s| < 0.172
    const double s = (m - 1.0) / (m + 1.0), q = s * s;
    double sum = 1.0 / 11.0;
    sum = sum * q + 1.0 / 9.0;
    sum = sum * q + 1.0 / 7.0;
    sum = sum * q + 1.0 / 5.0;
    sum = sum * q + 1.0 / 3.0;
    sum = sum * q + 1.0;
    const double x = (2.0 * s * sum + double(binary) * 0.6931471805599453) * double(exponent);
    if (!(x > -87.0)) // below the least normal float
        return 0.0f;
    const double scaled = x * 1.4426950408889634 - 0.5;
    const int power = int(scaled); // towards zero: the nearest whole number, as x is at most 0
    const double rest = x - double(power) * 0.6931471805599453;
    double series = 1.0 / 362880.0;
    series = series * rest + 1.0 / 40320.0;
    series = series * rest + 1.0 / 5040.0;
    series = series * rest + 1.0 / 720.0;
    series = series * rest + 1.0 / 120.0;
    series = series * rest + 1.0 / 24.0;
    series = series * rest + 1.0 / 6.0;
    series = series * rest + 0.5;
    series = series * rest + 1.0;
    series = series * rest + 1.0;
    return float(series * std::bit_cast<double>(uint64_t(power + 1023) << 52));
}

// A screen's value, 0 to 1, of an exposed one. NaN is black.
inline float toneMapped(float exposed, float inverseGamma) {
    if (!(exposed > 0.0f))
        return 0.0f;
    return exposed < 1.0f ? powerOf(exposed, inverseGamma) : 1.0f;
}

} // namespace sunstone::denoise
