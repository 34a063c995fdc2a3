// SPDX-License-Identifier: Apache-2.0
#include "denoise/history.h"

#include <algorithm>
#include <cmath>

namespace sunstone::denoise {
namespace {

// A previous colour may leave the new one by this many standard deviations of what the new one may
// be wrong by: the noise left in it (which the filter knows only roughly) and, as the flow is not
// exact, part of the change over its neighbourhood.
constexpr float kRange = 1.5f;
constexpr float kNoisePart = 8.0f;
constexpr float kChangePart = 0.15f;
constexpr float kSmall = 1e-12f;
constexpr float kLargestFlow = 1e6f;

struct Moments {
    float sum[3] = {}, squares[3] = {};
    int count = 0;

    void add(const float* color) {
        for (int c = 0; c < 3; ++c) {
            sum[c] += color[c];
            squares[c] += color[c] * color[c];
        }
        ++count;
    }
    float mean(int c) const { return sum[c] / float(count); }
    float variance(int c) const {
        return std::max(0.0f, squares[c] / float(count) - mean(c) * mean(c));
    }
    float variance() const { return variance(0) + variance(1) + variance(2); }
};

int64_t clampTo(int64_t value, uint32_t size) {
    return std::clamp<int64_t>(value, 0, int64_t(size) - 1);
}

struct Reader {
    const Image& image;
    const float (&scale)[3];

    // False if the pixel is not finite.
    bool read(int64_t x, int64_t y, float (&color)[3]) const {
        float values[4] = {};
        readPixel(image, uint32_t(clampTo(x, image.width)), uint32_t(clampTo(y, image.height)),
                  values);
        bool usable = true;
        for (int c = 0; c < 3; ++c) {
            color[c] = values[c] * scale[c];
            usable = usable && std::abs(color[c]) < 1e8f;
        }
        return usable;
    }

    // Bilinear; false outside the image or next to a pixel that is not finite. The place is given
    // as a pixel and a fraction: the sum of both would round differently in tiles.
    bool sample(int64_t x, int64_t y, float fractionX, float fractionY, float (&color)[3]) const {
        auto isInside = [](int64_t at, float fraction, uint32_t size) {
            return (at >= 0 || (at == -1 && fraction > 0.5f)) &&
                   (at + 1 < int64_t(size) || (at + 1 == int64_t(size) && fraction < 0.5f));
        };
        if (!isInside(x, fractionX, image.width) || !isInside(y, fractionY, image.height))
            return false;
        color[0] = color[1] = color[2] = 0.0f;
        for (int dy = 0; dy < 2; ++dy)
            for (int dx = 0; dx < 2; ++dx) {
                float w = (dx ? fractionX : 1.0f - fractionX) * (dy ? fractionY : 1.0f - fractionY);
                if (w == 0.0f)
                    continue;
                float corner[3];
                if (!read(x + dx, y + dy, corner))
                    return false;
                for (int c = 0; c < 3; ++c)
                    color[c] += w * corner[c];
            }
        return true;
    }

    Moments around(int64_t column, int64_t row) const {
        Moments moments;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                float color[3];
                if (read(column + dx, row + dy, color))
                    moments.add(color);
            }
        return moments;
    }
};

Moments momentsAt(const Planes& planes, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                  size_t stride) {
    Moments moments;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            size_t at = size_t(clampTo(int64_t(y) + dy, height)) * stride +
                        size_t(clampTo(int64_t(x) + dx, width));
            float color[3] = {planes.color[0][at], planes.color[1][at], planes.color[2][at]};
            moments.add(color);
        }
    return moments;
}

} // namespace

void History::blendRow(uint32_t y, uint32_t width, uint32_t height, size_t stride,
                       const Planes& from, const Planes& to) const {
    Reader reader{previous, scale};
    for (uint32_t x = 0; x < width; ++x) {
        size_t at = y * stride + x;
        for (int c = 0; c < 3; ++c)
            to.color[c][at] = from.color[c][at];
        float moved[4] = {}, old[3];
        readPixel(flow, x / factor, y / factor, moved);
        moved[0] *= float(factor);
        moved[1] *= float(factor);
        if (!(std::abs(moved[0]) < kLargestFlow && std::abs(moved[1]) < kLargestFlow))
            continue;
        float left = std::floor(-moved[0]), top = std::floor(-moved[1]);
        float fractionX = -moved[0] - left, fractionY = -moved[1] - top;
        int64_t oldX = int64_t(x) + int64_t(left), oldY = int64_t(y) + int64_t(top);
        if (!reader.sample(oldX, oldY, fractionX, fractionY, old))
            continue;
        Moments now = momentsAt(from, x, y, width, height, stride);
        float noise = kNoisePart * from.variance[at];
        float rough =
            reader.around(oldX + (fractionX >= 0.5f), oldY + (fractionY >= 0.5f)).variance();
        float trust = weight * std::min(1.0f, (now.variance() + noise + kSmall) / (rough + kSmall));
        for (int c = 0; c < 3; ++c) {
            float reach = kRange * std::sqrt(kChangePart * now.variance(c) + noise);
            float change = std::clamp(old[c] - from.color[c][at], -reach, reach);
            to.color[c][at] += change * trust;
        }
    }
}

} // namespace sunstone::denoise
