// SPDX-License-Identifier: Apache-2.0
#include "denoise/statistics.h"

#include "base/threads/threads.h"

#include <vector>

namespace sunstone::denoise {
namespace {

constexpr size_t kRowsPerTask = 8;

template <class Logs>
Logs logsOf(const Image& image) {
    std::vector<Logs> rows(image.height);
    parallelFor(image.height, kRowsPerTask, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (uint32_t x = 0; x < image.width; ++x) {
                float channels[4] = {};
                readPixel(image, x, uint32_t(y), channels);
                rows[y].add(channels);
            }
    });
    Logs total;
    for (const Logs& row : rows)
        for (int i = 0; i < Logs::kSums; ++i)
            total.sums[i].add(row.sums[i]);
    return total;
}

} // namespace

float intensityScale(const Image& image) {
    float result;
    logsOf<LuminanceLogs>(image).result(&result);
    return result;
}

void averageLogColor(const Image& image, float (&result)[3]) {
    logsOf<ColorLogs>(image).result(result);
}

} // namespace sunstone::denoise
