// SPDX-License-Identifier: Apache-2.0
// Logarithm and exponential by arithmetic that gives the same bits everywhere (libraries differ,
// and a GPU has none). Nothing here may be fused.
#pragma once

#include <bit>
#include <cstdint>

namespace sunstone::denoise {

constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33;

// ln of a positive, finite, normal number; the absolute or relative error is about 1e-15.
inline double logarithm(double value) {
    const uint64_t bits = std::bit_cast<uint64_t>(value);
    int exponent = int(bits >> 52) - 1023;
    double m = std::bit_cast<double>((bits & 0xFFFFFFFFFFFFFull) | 0x3FF0000000000000ull);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        ++exponent;
    }
    // m is at most sqrt(2) away from 1: |s| < 0.172.
    const double s = (m - 1.0) / (m + 1.0), square = s * s;
    double sum = 0.0;
    for (int i = 19; i >= 1; i -= 2)
        sum = sum * square + 1.0 / double(i);
    return 2.0 * s * sum + (double(exponent) * kLn2Low + double(exponent) * kLn2High);
}

// exp(x), with x clamped to [-700, 700]. NaN stays NaN.
inline double exponential(double x) {
    const double least = x < -700.0 ? -700.0 : x;
    const double clamped = least > 700.0 ? 700.0 : least;
    if (!(clamped == clamped))
        return clamped;
    const double scaled = clamped * 1.4426950408889634 + 0.5;
    const int truncated = int(scaled);
    const int power = double(truncated) > scaled ? truncated - 1 : truncated;
    const double rest = clamped - double(power) * kLn2High - double(power) * kLn2Low;
    double sum = 1.0;
    for (int i = 14; i >= 1; --i)
        sum = 1.0 + sum * rest / double(i);
    return sum * std::bit_cast<double>(uint64_t(power + 1023) << 52);
}

} // namespace sunstone::denoise
