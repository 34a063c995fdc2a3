// SPDX-License-Identifier: Apache-2.0
#include "denoise/statistics.h"

#include "base/threads.h"

#include <array>
#include <cmath>
#include <vector>

namespace sunstone::denoise {
namespace {

constexpr float kDarkest = 1e-8f;
constexpr size_t kRowsPerTask = 8;

struct Mean {
    double sum = 0;
    uint64_t count = 0;

    void add(float value) {
        if (!(value > kDarkest) || !std::isfinite(value))
            return;
        sum += std::log(double(value));
        ++count;
    }
    void add(const Mean& other) {
        sum += other.sum;
        count += other.count;
    }
    double value() const { return count ? sum / double(count) : 0.0; }
};

template <size_t kCount, class PerPixel>
std::array<Mean, kCount> meansOf(const Image& image, PerPixel perPixel) {
    std::vector<std::array<Mean, kCount>> rows(image.height);
    parallelFor(image.height, kRowsPerTask, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (uint32_t x = 0; x < image.width; ++x) {
                float channels[4] = {};
                readPixel(image, x, uint32_t(y), channels);
                perPixel(channels, rows[y]);
            }
    });
    std::array<Mean, kCount> total;
    for (const auto& row : rows)
        for (size_t i = 0; i < kCount; ++i)
            total[i].add(row[i]);
    return total;
}

} // namespace

float intensityScale(const Image& image) {
    auto mean = meansOf<1>(image, [](const float(&c)[4], std::array<Mean, 1>& means) {
        means[0].add(c[0] * 0.212586f + c[1] * 0.715170f + c[2] * 0.072200f);
    })[0];
    return mean.count ? float(0.18 / std::exp(mean.value())) : 1.0f;
}

void averageLogColor(const Image& image, float (&result)[3]) {
    auto means = meansOf<3>(image, [](const float(&c)[4], std::array<Mean, 3>& each) {
        for (int i = 0; i < 3; ++i)
            each[size_t(i)].add(c[i]);
    });
    for (size_t i = 0; i < 3; ++i)
        result[i] = float(means[i].value());
}

} // namespace sunstone::denoise
