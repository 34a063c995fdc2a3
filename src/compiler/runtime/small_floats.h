// SPDX-License-Identifier: Apache-2.0
// Codes of formats and roundings that the translator passes to the run-time's conversions.
#pragma once

#include <cstdint>

namespace sunstone::compiler {

enum class SmallFormat : uint32_t { kHalf, kBrain, kTensor32, kE4m3, kE5m2 };
enum class SmallRounding : uint32_t { kNearest, kZero, kDown, kUp, kAway };
// Flag added to the rounding: values above the range become the largest finite number.
constexpr uint32_t kSmallFinite = 8;

// The bits of a number in a format; the canonical NaN for any NaN. tf32: without its 13 low bits.
uint32_t encodeSmall(double value, uint32_t format, uint32_t how);
float decodeSmall(uint32_t code, uint32_t format);

} // namespace sunstone::compiler
