// SPDX-License-Identifier: Apache-2.0
// Statistics that scale images of any brightness to the range a filter expects. Logarithms are
// added up as integers, so that results depend neither on the order of pixels nor on the device.
#pragma once

#include "denoise/image.h"
#include "denoise/logarithm.h"

namespace sunstone::denoise {

// 0.18 / exp(mean of ln L) over the pixels whose luminance L is above 1e-8 (Reinhard et al. 2002);
// 1 if there are none. Pixels that are not finite do not count.
float intensityScale(const Image& image);

// For each of the first three channels the mean of ln c over the values c above 1e-8; 0 if there
// are none. Values that are not finite do not count.
void averageLogColor(const Image& image, float (&result)[3]);

// ---- Shared by CPUs and threads of GPUs ---------------------------------------------------------

constexpr float kDarkest = 1e-8f;
// Logarithms are below 128 in magnitude: at this many units for 1 a sum of 2^34 logarithms fits.
constexpr double kLogUnits = 0x1p22;

struct LogSum {
    int64_t sum;
    uint64_t count;

    void add(float value) {
        if (!(value > kDarkest) || !(value < __builtin_inff()))
            return;
        const double units = logarithm(double(value)) * kLogUnits;
        sum += int64_t(units + (units < 0.0 ? -0.5 : 0.5));
        ++count;
    }
    void add(const LogSum& other) {
        sum += other.sum;
        count += other.count;
    }
    double mean() const { return count ? double(sum) / double(count) / kLogUnits : 0.0; }
};

// The sums over the pixels of an image.
struct LuminanceLogs {
    static constexpr int kSums = 1;
    LogSum sums[kSums] = {};

    void add(const float (&c)[4]) {
        sums[0].add(c[0] * 0.212586f + c[1] * 0.715170f + c[2] * 0.072200f);
    }
    void result(float* to) const {
        to[0] = sums[0].count ? float(0.18 / exponential(sums[0].mean())) : 1.0f;
    }
};
struct ColorLogs {
    static constexpr int kSums = 3;
    LogSum sums[kSums] = {};

    void add(const float (&c)[4]) {
        for (int i = 0; i < kSums; ++i)
            sums[i].add(c[i]);
    }
    void result(float* to) const {
        for (int i = 0; i < kSums; ++i)
            to[i] = float(sums[i].mean());
    }
};

} // namespace sunstone::denoise
