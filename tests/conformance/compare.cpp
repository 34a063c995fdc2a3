// SPDX-License-Identifier: Apache-2.0
// See compare.h.
#include "compare.h"

#include "inputs.h"
#include "module_writer.h"
#include "recording.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace conformance {

namespace {

constexpr unsigned kShown = 4; // vectors of a form in the report

struct FloatFormat {
    unsigned bits, mantissa;
};

FloatFormat formatOf(const std::string& type) {
    if (type.starts_with("bf16"))
        return {16, 7};
    if (type.starts_with("f16"))
        return {16, 10};
    if (type == "f64")
        return {64, 52};
    return {32, 23};
}

uint64_t magnitudeOf(FloatFormat format, uint64_t bits) {
    return bits & ((1ull << (format.bits - 1)) - 1);
}
bool isNan(FloatFormat format, uint64_t bits) {
    const uint64_t infinity = ((1ull << (format.bits - 1 - format.mantissa)) - 1)
                              << format.mantissa;
    return magnitudeOf(format, bits) > infinity;
}
bool isFloatType(const std::string& type) {
    return type[0] == 'f' || type.starts_with("bf") || type == "arg";
}

double valueOf(FloatFormat format, uint64_t bits) {
    const int bias = (1 << (format.bits - 2 - format.mantissa)) - 1;
    const uint64_t magnitude = magnitudeOf(format, bits);
    const auto exponent = int(magnitude >> format.mantissa);
    const uint64_t fraction = magnitude & ((1ull << format.mantissa) - 1);
    double value = 0;
    if (exponent == 2 * bias + 1)
        value = fraction ? std::nan("") : INFINITY;
    else if (exponent == 0)
        value = std::ldexp(double(fraction), 1 - bias - int(format.mantissa));
    else
        value = std::ldexp(double(fraction | 1ull << format.mantissa),
                           exponent - bias - int(format.mantissa));
    return bits >> (format.bits - 1) & 1 ? -value : value;
}

// The number of steps between two numbers of a format; both zeros are one number.
double stepsBetween(FloatFormat format, uint64_t a, uint64_t b) {
    const auto place = [&](uint64_t bits) {
        const auto magnitude = double(magnitudeOf(format, bits));
        return bits >> (format.bits - 1) & 1 ? -magnitude : magnitude;
    };
    return std::fabs(place(a) - place(b));
}

bool agree(const Rule& rule, FloatFormat format, uint64_t want, uint64_t got) {
    if (want == got)
        return true;
    if (rule.kind == Rule::kExact)
        return false;
    const bool nanA = isNan(format, want), nanB = isNan(format, got);
    if (nanA || nanB)
        return nanA && nanB;
    const double a = valueOf(format, want), b = valueOf(format, got);
    if (rule.flushEdge && (a == 0) != (b == 0) && (want ^ got) == 1ull << format.mantissa)
        return true;
    switch (rule.kind) {
    case Rule::kUlp:
        return stepsBetween(format, want, got) <= rule.bound;
    case Rule::kMixed:
        return std::fabs(a - b) <= rule.bound * std::max(1.0, std::fabs(a));
    case Rule::kAbsolute:
        return std::fabs(a - b) <= rule.bound;
    case Rule::kRelative:
        // Below the normal range one step may be more than the bound.
        return std::fabs(a - b) <= rule.bound * std::fabs(a) ||
               (std::isfinite(a) && stepsBetween(format, want, got) <= 1);
    default:
        return false;
    }
}

uint64_t elementAt(const uint8_t* results, unsigned bytes, unsigned index) {
    uint64_t value = 0;
    std::memcpy(&value, results + size_t(index) * bytes, bytes);
    return value;
}

bool agreeOutput(const Output& output, uint64_t want, uint64_t got) {
    const FloatFormat format = formatOf(output.type);
    if (!output.type.ends_with("x2"))
        return agree(output.rule, format, want, got);
    return agree(output.rule, format, want & 0xffff, got & 0xffff) &&
           agree(output.rule, format, want >> 16, got >> 16);
}

bool isLimited(const Form& form, const Rule& rule, unsigned index) {
    if (rule.limited < 0)
        return false;
    const std::string& type = form.inputs[size_t(rule.limited)];
    const double value = valueOf(formatOf(type), inputBits(type, unsigned(rule.limited), index));
    return std::isfinite(value) && std::fabs(value) > rule.limit;
}

std::string show(const std::string& type, uint64_t bits) {
    char text[64];
    std::snprintf(text, sizeof text, "%0*llx", int(widthOf(type) + 3) / 4,
                  static_cast<unsigned long long>(bits));
    std::string shown = text;
    if (isFloatType(type) && !type.ends_with("x2")) {
        std::snprintf(text, sizeof text, " (%.9g)", valueOf(formatOf(type), bits));
        shown += text;
    }
    return shown;
}

std::string describe(const Form& form, unsigned index, size_t output, uint64_t want, uint64_t got) {
    std::string text = "  vector " + std::to_string(index) + ":";
    for (unsigned i = 0; i < form.inputs.size(); ++i)
        text += " a" + std::to_string(i) + "=" +
                show(form.inputs[i], inputBits(form.inputs[i], i, index));
    const std::string& type = form.outputs[output].type;
    return text + "  d" + std::to_string(output) + "=" + show(type, got) + ", recorded " +
           show(type, want) + "\n";
}

} // namespace

Difference compare(const Form& form, const std::vector<uint8_t>& recorded,
                   const std::vector<uint8_t>& results) {
    Difference difference;
    if (recorded.size() != results.size())
        return {kVectors, "  the recording has another size\n", 0};
    size_t offset = 0;
    for (size_t k = 0; k < form.outputs.size(); ++k) {
        const Output& output = form.outputs[k];
        const unsigned bytes = bytesOf(output.type);
        for (unsigned i = 0; i < kVectors; ++i) {
            const uint64_t want = elementAt(recorded.data() + offset, bytes, i);
            const uint64_t got = elementAt(results.data() + offset, bytes, i);
            if (agreeOutput(output, want, got) || isLimited(form, output.rule, i))
                continue;
            const uint64_t where[3] = {difference.digest, k * kVectors + i, got};
            difference.digest = hashOf(where, sizeof where);
            if (difference.vectors++ < kShown)
                difference.text += describe(form, i, k, want, got);
        }
        offset += size_t(bytes) * kVectors;
    }
    return difference;
}

} // namespace conformance
