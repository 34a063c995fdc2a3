// SPDX-License-Identifier: Apache-2.0
// Structural similarity of two images over a block of pixels (Wang et al. 2004, with a uniform
// window). Sums are in one order, so that CPUs and GPUs have equal bits.
#pragma once

#include <cstdint>

namespace sunstone::denoise {

constexpr uint32_t kStructureBlock = 16;

struct StructureSums {
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    uint32_t count = 0;

    void add(float first, float second) {
        const double x = double(first), y = double(second);
        a += x;
        b += y;
        aa += x * x;
        bb += y * y;
        ab += x * y;
        ++count;
    }
    // 1: equal; 0: nothing in common. Of values from 0 to 1.
    float similarity() const {
        constexpr double kMeans = 0.01 * 0.01, kVariances = 0.03 * 0.03; // against division by 0
        const double n = double(count);
        const double meanA = a / n, meanB = b / n;
        const double varianceA = aa / n - meanA * meanA, varianceB = bb / n - meanB * meanB;
        const double covariance = ab / n - meanA * meanB;
        const double value =
            (2.0 * meanA * meanB + kMeans) * (2.0 * covariance + kVariances) /
            ((meanA * meanA + meanB * meanB + kMeans) * (varianceA + varianceB + kVariances));
        return value > 0.0 ? value < 1.0 ? float(value) : 1.0f : 0.0f;
    }
};

} // namespace sunstone::denoise
