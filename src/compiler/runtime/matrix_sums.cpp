// SPDX-License-Identifier: Apache-2.0
// Sums of products with the bits of an H100. The manual leaves open how tensor cores round; these
// rules were derived from recordings and reproduce their bits (tests/conformance,
// docs/conformance.md):
//
// - halves, bfloats and tf32: all products of a row and a column and the sum so far are exact. They
//   are shifted to the greatest exponent (products of significands are not normalised first),
//   truncated to 25 bits after the binary point, and added exactly. A single is truncated from
//   that, a half rounded to nearest. wmma of tf32 takes two such steps.
// - bytes (e4m3, e5m2): like halves, in two steps: the first two of every four neighbours, then the
//   other two. The sum so far is added last, rounded to nearest.
// - m8n8k4 of halves: a chain of fused operations in single precision. It starts with the sum so
//   far if the result is a half, else with zero, and the sum so far is added last.
// - doubles: a chain of fused operations.
//
// All NaN results are the canonical NaN.
#include "compiler/runtime/matrix.h"

#include "base/error.h"

#include <algorithm>
#include <bit>
#include <cfenv>
#include <cmath>
#include <limits>

namespace sunstone::compiler {

namespace {

int64_t signExtend(uint64_t bits, unsigned count) {
    return int64_t(bits << (64 - count)) >> (64 - count);
}

uint64_t sumIntegers(const MatrixOperation& operation, const uint64_t* a, const uint64_t* b,
                     unsigned count, uint64_t c) {
    int64_t sum = int32_t(c);
    for (unsigned i = 0; i < count; ++i)
        sum += int64_t(a[i]) * int64_t(b[i]);
    if (operation.has(kMatrixSaturates))
        sum = std::clamp<int64_t>(sum, INT32_MIN, INT32_MAX);
    return uint32_t(sum);
}

uint64_t countBits(const MatrixOperation& operation, const uint64_t* a, const uint64_t* b,
                   unsigned count, uint64_t c) {
    uint32_t sum = uint32_t(c);
    for (unsigned i = 0; i < count; ++i)
        sum += uint32_t(std::popcount(operation.has(kMatrixAnd) ? a[i] & b[i] : a[i] ^ b[i]));
    return sum;
}

uint64_t sumDoubles(const MatrixOperation& operation, const uint64_t* a, const uint64_t* b,
                    unsigned count, uint64_t c) {
    static constexpr int kModes[] = {FE_TONEAREST, FE_TOWARDZERO, FE_DOWNWARD, FE_UPWARD};
    std::fesetround(kModes[operation.rounding % 4]);
    double sum = std::bit_cast<double>(c);
    for (unsigned i = 0; i < count; ++i)
        sum = std::fma(std::bit_cast<double>(a[i]), std::bit_cast<double>(b[i]), sum);
    std::fesetround(FE_TONEAREST);
    return std::isnan(sum) ? 0xfff8000000000000 : std::bit_cast<uint64_t>(sum);
}

// ---- numbers ----------------------------------------------------------------------------------

struct Format {
    unsigned bits, exponentBits, fractionBits;
    unsigned unused; // low bits that are ignored
};

Format formatOf(MatrixType type) {
    switch (type) {
    case MatrixType::kF16:
        return {16, 5, 10, 0};
    case MatrixType::kBF16:
        return {16, 8, 7, 0};
    case MatrixType::kTF32:
        return {32, 8, 10, 13};
    case MatrixType::kE4M3:
        return {8, 4, 3, 0};
    case MatrixType::kE5M2:
        return {8, 5, 2, 0};
    default:
        return {32, 8, 23, 0};
    }
}

// A decoded float: significand * 2^(exponent - fraction bits). Eight bytes, so that a matrix of
// bits can be converted in place.
struct Factor {
    int32_t significand = 0; // with sign
    int16_t exponent = kOfZero;
    enum Kind : int16_t { kFinite = 0, kInfinite = 1, kNan = 2 };
    Kind kind = kFinite;
    static constexpr int16_t kOfZero = -8192; // less than those of all nonzero products
};
static_assert(sizeof(Factor) == sizeof(uint64_t));

Factor decode(MatrixType type, uint64_t bits) {
    const Format format = formatOf(type);
    bits >>= format.unused;
    const bool isNegative = bits >> (format.exponentBits + format.fractionBits) & 1;
    const uint64_t most = (uint64_t(1) << format.exponentBits) - 1;
    const uint64_t exponent = bits >> format.fractionBits & most;
    const uint64_t fraction = bits & ((uint64_t(1) << format.fractionBits) - 1);
    const int bias = int(most / 2);
    Factor factor;
    if (type == MatrixType::kE4M3) { // no infinities, one NaN
        if (exponent == most && fraction == 7)
            factor.kind = Factor::kNan;
    } else if (exponent == most) {
        factor.kind = fraction ? Factor::kNan : Factor::kInfinite;
    }
    const auto significand =
        int32_t(exponent ? fraction | uint64_t(1) << format.fractionBits : fraction);
    factor.significand = isNegative ? -significand : significand;
    if (significand != 0)
        factor.exponent = int16_t((exponent ? int(exponent) : 1) - bias);
    return factor;
}

uint64_t canonicalNan(MatrixType type) {
    return type == MatrixType::kF16 ? 0x7fff : 0x7fffffff;
}

uint64_t infinityOf(MatrixType type, bool isNegative) {
    const Format format = formatOf(type);
    return uint64_t(isNegative) << (format.bits - 1) | ((uint64_t(1) << format.exponentBits) - 1)
                                                           << format.fractionBits;
}

// value * 2^exponent, truncated or, for halves, rounded to nearest.
uint64_t encode(MatrixType type, int64_t value, int exponent) {
    const Format format = formatOf(type);
    const uint64_t magnitude = uint64_t(std::abs(value));
    if (magnitude == 0)
        return 0;
    const int bias = (1 << (format.exponentBits - 1)) - 1;
    const int top = std::max(63 - std::countl_zero(magnitude) + exponent, 1 - bias);
    const int shift = top - int(format.fractionBits) - exponent; // to the last bit kept
    uint64_t kept = 0;
    if (shift <= 0) {
        kept = magnitude << -shift;
    } else if (shift < 64) {
        kept = magnitude >> shift;
        const uint64_t rest = magnitude & ((uint64_t(1) << shift) - 1);
        const uint64_t half = uint64_t(1) << (shift - 1);
        if (type == MatrixType::kF16 && (rest > half || (rest == half && kept & 1)))
            ++kept;
    }
    // The leading bit of a normal number adds one to the exponent.
    const uint64_t all = (uint64_t(top + bias - 1) << format.fractionBits) + kept;
    const uint64_t most = infinityOf(type, false);
    return uint64_t(value < 0) << (format.bits - 1) | std::min(all, most);
}

float toFloat(MatrixType type, uint64_t bits) {
    const Factor factor = decode(type, bits);
    const bool isNegative = bits >> (formatOf(type).bits - 1) & 1;
    float magnitude = factor.kind == Factor::kNan ? std::numeric_limits<float>::quiet_NaN()
                      : factor.kind == Factor::kInfinite
                          ? std::numeric_limits<float>::infinity()
                          : std::ldexp(float(std::abs(factor.significand)),
                                       factor.exponent - int(formatOf(type).fractionBits));
    return isNegative ? -magnitude : magnitude;
}

uint64_t fromFloat(MatrixType type, float value) {
    if (std::isnan(value))
        return canonicalNan(type);
    if (type == MatrixType::kF32)
        return std::bit_cast<uint32_t>(value);
    const bool isNegative = std::signbit(value);
    if (std::isinf(value))
        return infinityOf(type, isNegative);
    if (value == 0)
        return isNegative ? 0x8000 : 0;
    const Factor factor = decode(MatrixType::kF32, std::bit_cast<uint32_t>(value));
    return encode(type, factor.significand, factor.exponent - 23) | uint64_t(isNegative) << 15;
}

// ---- sums of floats ---------------------------------------------------------------------------

// The result of a sum with infinities or NaNs; false if it has none.
bool sumSpecial(MatrixType result, const uint64_t* a, const uint64_t* b, unsigned count,
                const Factor& c, uint64_t& bits) {
    bool isNan = c.kind == Factor::kNan;
    bool signs[2] = {}; // signs of the infinities found
    if (c.kind == Factor::kInfinite)
        signs[c.significand < 0] = true;
    for (unsigned i = 0; i < count; ++i) {
        const auto x = std::bit_cast<Factor>(a[i]), y = std::bit_cast<Factor>(b[i]);
        if (x.kind == Factor::kFinite && y.kind == Factor::kFinite)
            continue;
        isNan |= x.kind == Factor::kNan || y.kind == Factor::kNan || x.significand == 0 ||
                 y.significand == 0;
        signs[(x.significand < 0) != (y.significand < 0)] = true;
    }
    if (!isNan && !signs[0] && !signs[1])
        return false;
    bits = isNan || (signs[0] && signs[1]) ? canonicalNan(result) : infinityOf(result, signs[1]);
    return true;
}

// `fraction`: bits after the binary point of a product of significands.
uint64_t sumAligned(MatrixType result, const uint64_t* a, const uint64_t* b, unsigned count,
                    int fraction, MatrixType sumType, uint64_t c) {
    constexpr int kKept = 25; // bits after the binary point
    constexpr unsigned kMost = 16;
    SUNSTONE_CHECK(count <= kMost && fraction <= kKept);
    const Factor start = decode(sumType, c);
    int highest = start.exponent, kinds = start.kind;
    int exponents[kMost];
    int64_t products[kMost];
    for (unsigned i = 0; i < count; ++i) {
        const auto x = std::bit_cast<Factor>(a[i]), y = std::bit_cast<Factor>(b[i]);
        kinds |= x.kind | y.kind;
        exponents[i] = x.exponent + y.exponent;
        products[i] = int64_t(x.significand) * y.significand;
        highest = std::max(highest, exponents[i]);
    }
    uint64_t bits = 0;
    if (kinds != Factor::kFinite && sumSpecial(result, a, b, count, start, bits))
        return bits;
    const auto aligned = [&](int64_t value, int exponent, int behind) {
        const int shift = std::min(highest - exponent, 63);
        const int64_t magnitude = std::abs(value) << (kKept - behind) >> shift;
        return value < 0 ? -magnitude : magnitude;
    };
    int64_t total = aligned(start.significand, start.exponent, int(formatOf(sumType).fractionBits));
    for (unsigned i = 0; i < count; ++i)
        total += aligned(products[i], exponents[i], fraction);
    return encode(result, total, highest - kKept);
}

uint64_t sumBytes(const MatrixOperation& operation, const uint64_t* a, const uint64_t* b,
                  unsigned count, uint64_t c) {
    constexpr int kFraction = 2 * 10; // bytes have been converted to halves
    uint64_t sum = 0;
    for (unsigned first : {0u, 2u}) {
        uint64_t x[16], y[16];
        unsigned length = 0;
        for (unsigned i = first; i < count; i += 4)
            for (unsigned k = i; k < i + 2; ++k) {
                x[length] = a[k];
                y[length++] = b[k];
            }
        sum = sumAligned(operation.d, x, y, length, kFraction, operation.d, sum);
    }
    return fromFloat(operation.d, toFloat(operation.d, sum) + toFloat(operation.c, c));
}

uint64_t sumChain(const MatrixOperation& operation, const uint64_t* a, const uint64_t* b,
                  unsigned count, uint64_t c) {
    const float start = toFloat(operation.c, c);
    const bool startsWithSum = operation.d == MatrixType::kF16;
    float sum = startsWithSum ? start : 0;
    for (unsigned i = 0; i < count; ++i)
        sum = std::fma(toFloat(operation.a, a[i]), toFloat(operation.b, b[i]), sum);
    return fromFloat(operation.d, startsWithSum ? sum : sum + start);
}

} // namespace

void prepareFactors(const MatrixOperation& operation, MatrixType type, uint64_t* values,
                    unsigned count) {
    if (operation.isQuad() || type == MatrixType::kF64 || type == MatrixType::kB1)
        return;
    const bool isByte = type == MatrixType::kE4M3 || type == MatrixType::kE5M2;
    for (unsigned i = 0; i < count; ++i) {
        if (type == MatrixType::kS8 || type == MatrixType::kS4) {
            values[i] = uint64_t(signExtend(values[i], bitsOfElement(type)));
        } else if (isFloat(type)) {
            if (isByte) // every byte value is exact as a half
                values[i] = fromFloat(MatrixType::kF16, toFloat(type, values[i]));
            values[i] =
                std::bit_cast<uint64_t>(decode(isByte ? MatrixType::kF16 : type, values[i]));
        }
    }
}

uint64_t sumProducts(const MatrixOperation& operation, const uint64_t* a, const uint64_t* b,
                     unsigned count, uint64_t c) {
    if (operation.a == MatrixType::kB1)
        return countBits(operation, a, b, count, c);
    if (!isFloat(operation.a))
        return sumIntegers(operation, a, b, count, c);
    if (operation.a == MatrixType::kF64)
        return sumDoubles(operation, a, b, count, c);
    if (operation.a == MatrixType::kE4M3 || operation.a == MatrixType::kE5M2)
        return sumBytes(operation, a, b, count, c);
    if (operation.isQuad())
        return sumChain(operation, a, b, count, c);
    const int fraction = 2 * int(formatOf(operation.a).fractionBits);
    const bool isWidened = operation.d == MatrixType::kF32 && operation.c == MatrixType::kF16;
    uint64_t sum = isWidened ? fromFloat(MatrixType::kF32, toFloat(MatrixType::kF16, c)) : c;
    const unsigned step =
        operation.a == MatrixType::kTF32 && operation.has(kMatrixWide) ? 4 : count;
    for (unsigned i = 0; i < count; i += step)
        sum = sumAligned(operation.d, a + i, b + i, step, fraction,
                         isWidened ? MatrixType::kF32 : operation.c, sum);
    return sum;
}

} // namespace sunstone::compiler
