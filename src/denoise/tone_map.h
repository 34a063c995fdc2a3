// SPDX-License-Identifier: Apache-2.0
// A tone curve: exposure, then a power. Compiled for CPUs and for threads of GPUs with the same
// bits as the result; nothing here may be fused.
#pragma once

#include <bit>
#include <cstdint>

namespace sunstone::denoise {

// `value` to the power of `exponent`, for normal values in (0, 1] and exponents above 0, with a
// relative error of about 2e-7. Single precision and constant coefficients, because it runs for
// each pixel; logarithm() and exponential() are for single values of an image.
inline float powerOf(float value, float exponent) {
    constexpr float kLn2High = 0x1.62e4p-1f, kLn2Low = 0x1.7f7d1cp-20f; // High has 15 bits
    // value = 2^binary m with m from sqrt(1/2) to sqrt(2)
    const int32_t bits = std::bit_cast<int32_t>(value), half = 0x3F3504F3;
    const int32_t binary = (bits - half) >> 23;
    const float m = std::bit_cast<float>(bits - binary * (1 << 23));
    // ln m = 2 (s + s^3/3 + s^5/5 ...) with |s| < 0.172
    const float s = (m - 1.0f) / (m + 1.0f), q = s * s;
    float sum = 1.0f / 9.0f;
    sum = sum * q + 1.0f / 7.0f;
    sum = sum * q + 1.0f / 5.0f;
    sum = sum * q + 1.0f / 3.0f;
    const float rest = 2.0f * s + (2.0f * s * q * sum + float(binary) * kLn2Low);
    const float exact = (float(binary) * kLn2High + rest) * exponent;
    const float x = exact > -87.0f ? exact : -87.0f; // the least normal float
    // Towards zero: the nearest whole number, as x is at most about 0.
    const int power = int(x * 1.44269504f - 0.5f);
    const float r = x - float(power) * kLn2High - float(power) * kLn2Low;
    float series = 1.0f / 5040.0f;
    series = series * r + 1.0f / 720.0f;
    series = series * r + 1.0f / 120.0f;
    series = series * r + 1.0f / 24.0f;
    series = series * r + 1.0f / 6.0f;
    series = series * r + 0.5f;
    series = series * r + 1.0f;
    series = series * r + 1.0f;
    const float result = series * std::bit_cast<float>((power + 127) * (1 << 23));
    const float some = exact > -87.0f ? result : 0.0f;
    return some < 1.0f ? some : 1.0f;
}

// A screen's value, 0 to 1, of an exposed one. NaN and values that are not normal are black.
inline float toneMapped(float exposed, float inverseGamma) {
    const bool isBlack = !(exposed >= 0x1p-126f), isWhite = exposed >= 1.0f;
    const float power = powerOf(isBlack || isWhite ? 1.0f : exposed, inverseGamma);
    return isBlack ? 0.0f : power;
}

} // namespace sunstone::denoise
