// SPDX-License-Identifier: Apache-2.0
// The weight of a distance, by arithmetic that gives the same bits everywhere (libraries differ).
#pragma once

#include <bit>
#include <cstdint>

namespace sunstone::denoise {
namespace { // local to each file, as files are compiled for different instruction sets

// exp(-x) for x >= 0 with a relative error below 1e-4; 0 from 60 on.
inline float falloff(float x) {
    float power = (x < 60.0f ? x : 60.0f) * -1.44269504f;
    int whole = int(power); // towards zero: the rest is in (-1, 0]
    float rest = power - float(whole);
    float value =
        1.0f + rest * (0.6931472f + rest * (0.2402265f + rest * (0.0555041f + rest * 0.0083360f)));
    float scale = std::bit_cast<float>(uint32_t(whole + 127) << 23);
    return x < 60.0f ? value * scale : 0.0f;
}

} // namespace
} // namespace sunstone::denoise
