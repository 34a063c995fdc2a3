// SPDX-License-Identifier: Apache-2.0
// The difference of two pictures (4 floats a pixel, linear) as a screen shows them: clipped at one,
// gamma 2.2.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

inline float shown(float value) {
    return std::pow(std::min(std::max(value, 0.0f), 1.0f), 1.0f / 2.2f);
}

// Peak signal-to-noise ratio in decibels; `counts(pixel)` picks pixels.
template <class Counts>
double psnr(const std::vector<float>& a, const std::vector<float>& b, Counts counts) {
    double sum = 0.0;
    size_t values = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        if (i % 4 == 3 || !counts(i / 4))
            continue;
        double difference = shown(a[i]) - shown(b[i]);
        sum += difference * difference;
        ++values;
    }
    return 10.0 * std::log10(double(std::max<size_t>(values, 1)) / std::max(sum, 1e-12));
}

inline double psnr(const std::vector<float>& a, const std::vector<float>& b) {
    return psnr(a, b, [](size_t) { return true; });
}
