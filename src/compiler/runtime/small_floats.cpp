// SPDX-License-Identifier: Apache-2.0
// Floating point formats without CPU arithmetic: conversions to bfloat16, tf32, e4m3 and e5m2 in
// every rounding, and the fused multiply-add of bfloat16. Inputs are doubles, exact or rounded to
// odd: a further rounding to fewer bits then gives the same result as a single rounding. Source:
// PTX ISA manual, "cvt".
#include "compiler/runtime/small_floats.h"

#include "compiler/runtime/runtime.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sunstone::compiler {

namespace {

struct Format {
    unsigned exponentBits, mantissaBits;
    uint32_t greatest; // finite magnitude
    bool infinity;
};

const Format& formatOf(uint32_t format) {
    static constexpr Format kFormats[] = {
        {5, 10, 0x7bff, true},  // kHalf
        {8, 7, 0x7f7f, true},   // kBrain
        {8, 10, 0x3fbff, true}, // kTensor32, without its 13 low bits
        {4, 3, 0x7e, false},    // kE4m3
        {5, 2, 0x7b, true},     // kE5m2
    };
    return kFormats[format & 7];
}

// Rounds a magnitude, in units of the last place.
uint64_t roundUnits(double units, bool negative, SmallRounding rounding) {
    const double whole = std::floor(units), rest = units - whole;
    const auto kept = uint64_t(whole);
    switch (rounding) {
    case SmallRounding::kNearest:
        return kept + (rest > 0.5 || (rest == 0.5 && (kept & 1)));
    case SmallRounding::kAway:
        return kept + (rest >= 0.5);
    case SmallRounding::kDown:
        return kept + (negative && rest > 0);
    case SmallRounding::kUp:
        return kept + (!negative && rest > 0);
    default:
        return kept;
    }
}

double toOdd(double rounded, bool inexact, bool tooSmall) {
    auto bits = std::bit_cast<uint64_t>(rounded);
    if (inexact && !(bits & 1) && std::isfinite(rounded))
        bits = tooSmall ? bits + 1 : bits - 1;
    return std::bit_cast<double>(bits);
}

template <class Integer>
double oddFromInteger(Integer value) {
    const long double exact = value; // 64 bits of mantissa
    const auto rounded = double(exact);
    return toOdd(rounded, rounded != exact, std::fabs(rounded) < std::fabs(exact));
}
double oddFromSigned(int64_t value) {
    return oddFromInteger(value);
}
double oddFromUnsigned(uint64_t value) {
    return oddFromInteger(value);
}

// a * b + c rounded to odd: the later rounding to bfloat16 gives the same result as a single one.
float fusedBrain(float a, float b, float c) {
    const double product = double(a) * double(b); // exact
    const double sum = product + double(c);
    if (!std::isfinite(sum))
        return float(sum);
    const double part = sum - product;
    const double error = (product - (sum - part)) + (double(c) - part);
    const double odd = toOdd(sum, error != 0, (error > 0) == (sum > 0));
    const auto single = float(odd);
    auto bits = std::bit_cast<uint32_t>(single);
    if (double(single) != odd && !(bits & 1))
        bits = std::fabs(double(single)) < std::fabs(odd) ? bits + 1 : bits - 1;
    return std::bit_cast<float>(bits);
}

template <class Function>
const void* addressOf(Function* function) {
    return reinterpret_cast<const void*>(function);
}

} // namespace

uint32_t encodeSmall(double value, uint32_t format, uint32_t how) {
    const Format& f = formatOf(format);
    const unsigned bits = 1 + f.exponentBits + f.mantissaBits;
    const uint32_t sign = std::signbit(value) ? 1u << (bits - 1) : 0;
    const auto rounding = SmallRounding(how & 7);
    if (std::isnan(value))
        return (1u << (bits - 1)) - 1;
    const int lowest = 2 - (1 << (f.exponentBits - 1)); // exponent of the least normal number
    uint64_t magnitude = uint64_t(f.greatest) + 1;
    if (std::isfinite(value)) {
        const int exponent = value == 0 ? lowest : std::max(lowest, std::ilogb(value));
        const double units = std::ldexp(std::fabs(value), int(f.mantissaBits) - exponent);
        if (exponent - lowest < 1 << f.exponentBits)
            magnitude = roundUnits(units, sign != 0, rounding) +
                        (uint64_t(exponent - lowest) << f.mantissaBits);
    }
    if (magnitude > f.greatest) {
        const bool away = rounding == SmallRounding::kNearest || rounding == SmallRounding::kAway ||
                          (rounding == SmallRounding::kUp && !sign) ||
                          (rounding == SmallRounding::kDown && sign);
        const bool finite = (how & kSmallFinite) || !f.infinity;
        magnitude = f.greatest;
        if (!finite && (away || std::isinf(value)))
            magnitude = f.greatest + 1;
    }
    return sign | uint32_t(magnitude);
}

float decodeSmall(uint32_t code, uint32_t format) {
    const Format& f = formatOf(format);
    const unsigned bits = 1 + f.exponentBits + f.mantissaBits;
    const uint32_t magnitude = code & ((1u << (bits - 1)) - 1);
    const float sign = code >> (bits - 1) & 1 ? -1.0f : 1.0f;
    if (magnitude > f.greatest)
        return f.infinity && magnitude == f.greatest + 1 ? sign * INFINITY : std::nanf("");
    const auto exponent = int(magnitude >> f.mantissaBits);
    const uint32_t fraction = magnitude & ((1u << f.mantissaBits) - 1);
    const uint32_t whole = fraction | (exponent ? 1u << f.mantissaBits : 0);
    const int scale = std::max(exponent, 1) - ((1 << (f.exponentBits - 1)) - 1);
    return sign * float(std::ldexp(double(whole), scale - int(f.mantissaBits)));
}

void addSmallFloatSymbols(std::vector<RuntimeSymbol>& symbols) {
    const RuntimeSymbol own[] = {
        {"sunstone_fma_bf16", addressOf(fusedBrain)},
        {"sunstone_encode_small", addressOf(encodeSmall)},
        {"sunstone_decode_small", addressOf(decodeSmall)},
        {"sunstone_odd_s64", addressOf(oddFromSigned)},
        {"sunstone_odd_u64", addressOf(oddFromUnsigned)},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

} // namespace sunstone::compiler
