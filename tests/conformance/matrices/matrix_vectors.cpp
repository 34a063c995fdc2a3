// SPDX-License-Identifier: Apache-2.0
// Contents of the matrices, equal on every machine. The problems reveal the alignment, truncation
// and rounding of products and sums: terms of similar and of very different size, sparse matrices,
// subnormals, infinities, overflow.
#include "driver.h"
#include "inputs.h"
#include "matrices/matrix_cases.h"

#include <algorithm>
#include <cstring>

namespace conformance {

namespace {

struct Format {
    const char* name;
    unsigned bits, exponent, fraction;
};
constexpr Format kFormats[] = {{"f64", 64, 11, 52}, {"f32", 32, 8, 23}, {"tf32", 32, 8, 23},
                               {"f16", 16, 5, 10},  {"bf16", 16, 8, 7}, {"e4m3", 8, 4, 3},
                               {"e5m2", 8, 5, 2}};

struct Kind {
    int spread, spreadC; // of exponents, to either side
    int shiftC;          // of C's exponents
    unsigned zeros;      // of 16 elements of A and B
};
constexpr Kind kKinds[kProblems] = {{0, 0, 0, 0}, // small whole numbers
                                    {1, 1, 0, 0},   {3, 6, 0, 0},   {6, 12, 0, 0}, //
                                    {2, 2, 8, 0},   {2, 2, 20, 0},  {2, 2, -12, 0},
                                    {2, 2, -24, 0}, //
                                    {0, 6, -28, 0}, // subnormals
                                    {7, 0, 0, 12},  {7, 10, 0, 14}, {2000, 2000, 0, 0}, //
                                    {3, 3, 0, 0},   // infinities
                                    {0, 0, 0, 0},   // any bits
                                    {0, 0, 0, 0},   // the largest numbers
                                    {0, 0, 0, 16}}; // zeros
constexpr unsigned kWhole = 0, kSubnormal = 8, kInfinite = 12, kAny = 13, kLarge = 14;

uint64_t wholeNumber(const Format& format, int value) {
    if (value == 0)
        return 0;
    unsigned size = unsigned(std::abs(value)), exponent = 0;
    while (size >> (exponent + 1))
        ++exponent;
    const uint64_t bias = (uint64_t(1) << (format.exponent - 1)) - 1;
    const uint64_t fraction =
        (uint64_t(size) << format.fraction >> exponent) & ((uint64_t(1) << format.fraction) - 1);
    return uint64_t(value < 0) << (format.bits - 1) | (bias + exponent) << format.fraction |
           fraction;
}

uint64_t floatBits(const Format& format, unsigned problem, bool isC, uint64_t random) {
    const Kind& kind = kKinds[problem];
    const uint64_t sign = (random >> 60 & 1) << (format.bits - 1);
    const uint64_t fraction = random & ((uint64_t(1) << format.fraction) - 1);
    const uint64_t most = (uint64_t(1) << format.exponent) - 1; // infinities and NaNs
    const uint64_t dice = scramble(random);
    if (problem == kWhole)
        return wholeNumber(format, int(dice % (format.fraction > 2 ? 17 : 9)) -
                                       (format.fraction > 2 ? 8 : 4));
    if (problem == kAny)
        return format.bits == 64 ? random : random & ((uint64_t(1) << format.bits) - 1);
    if (!isC && dice % 16 < kind.zeros)
        return sign;
    if (isC && kind.zeros == 16)
        return sign;
    if (problem == kInfinite && dice % 64 == 0)
        return sign | most << format.fraction;
    if (problem == kSubnormal && !isC)
        return sign | (dice >> 8 & 1) << format.fraction | fraction;
    if (problem == kLarge)
        return sign | (most - 1 - (isC ? dice >> 8 & 1 : dice >> 8 & 3)) << format.fraction |
               fraction;
    const int spread = isC ? kind.spreadC : kind.spread;
    const int64_t bias = int64_t(most / 2);
    const int64_t exponent =
        bias + int64_t((dice >> 8) % uint64_t(2 * spread + 1)) - spread + (isC ? kind.shiftC : 0);
    return sign | uint64_t(std::clamp<int64_t>(exponent, 0, int64_t(most) - 1)) << format.fraction |
           fraction;
}

// Sums near the ends of the range, so that they saturate or wrap.
uint32_t sumBits(unsigned problem, uint64_t random) {
    if (problem % 2)
        return uint32_t(random);
    const uint32_t near = uint32_t(random) & 0x3fff;
    return random >> 40 & 1 ? 0x7fffffff - near : 0x80000000 + near;
}

} // namespace

std::vector<uint8_t> matrixContent(const MatrixCase& test, unsigned problem) {
    std::vector<uint8_t> all(kProblemBytes);
    for (unsigned area = 0; area < 3; ++area) {
        const std::string& type = test.types[area];
        uint8_t* at = all.data() + area * kAreaBytes;
        const auto* format = std::find_if(std::begin(kFormats), std::end(kFormats),
                                          [&](const Format& f) { return type == f.name; });
        const bool isFloat = format != std::end(kFormats);
        const size_t bytes = isFloat ? format->bits / 8 : type == "s32" ? 4 : 1;
        for (size_t i = 0; i < kAreaBytes / bytes; ++i) {
            const uint64_t random = scramble(scramble(i * 3 + area) + problem);
            uint64_t bits = random;
            if (isFloat)
                bits = floatBits(*format, problem, area == 2, random);
            else if (type == "s32")
                bits = sumBits(problem, random);
            else if (problem == 2) // the ends of all integers
                bits = random >> 20 & 1 ? 0x88 : 0x77;
            else if (problem == 4)
                bits = random >> 20 & 1 ? 0xff : 0x80;
            std::memcpy(at + i * bytes, &bits, bytes);
        }
    }
    return all;
}

} // namespace conformance
