// SPDX-License-Identifier: Apache-2.0
// Temporal blending: the previous denoised image, moved by the flow, makes the new one steadier. It
// is used only where it fits: inside the image, within the range of the new pixel's neighbourhood,
// and no rougher than that neighbourhood (the first previous image may be noisy). Compiled for CPUs
// and for threads of GPUs.
#pragma once

#include "denoise/image.h"
#include "denoise/rows/rows.h"

namespace sunstone::denoise {

constexpr int kHistoryRadius = 1;

// A previous colour may differ from the new one by this many standard deviations of the new one's
// error. The error is the remaining noise (which the filter only estimates) and, because the flow
// is not exact, part of the change over the neighbourhood.
constexpr float kRange = 1.5f;
constexpr float kNoisePart = 8.0f;
constexpr float kChangePart = 0.15f;
constexpr float kSmallVariance = 1e-12f;
constexpr float kLargestFlow = 1e6f;

struct ColorMoments {
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

// Reads an image, scaled to the range of the planes.
struct Reader {
    const Image& image;
    const float (&scale)[3];

    // False if the pixel is not finite.
    bool read(int x, int y, float (&color)[3]) const {
        float values[4] = {};
        readPixel(image, clampTo(x, image.width), clampTo(y, image.height), values);
        bool usable = true;
        for (int c = 0; c < 3; ++c) {
            color[c] = values[c] * scale[c];
            usable = usable && __builtin_fabsf(color[c]) < 1e8f;
        }
        return usable;
    }

    // Bilinear; false outside the image or next to a pixel that is not finite. The position is a
    // pixel and a fraction, because their sum would round differently in tiles.
    bool sample(int x, int y, float fractionX, float fractionY, float (&color)[3]) const {
        auto isInside = [](int at, float fraction, uint32_t size) {
            return (at >= 0 || (at == -1 && fraction > 0.5f)) &&
                   (at + 1 < int(size) || (at + 1 == int(size) && fraction < 0.5f));
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

    ColorMoments around(int column, int row) const {
        ColorMoments moments;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                float color[3];
                if (read(column + dx, row + dy, color))
                    moments.add(color);
            }
        return moments;
    }
};

inline ColorMoments momentsAt(const Planes& planes, uint32_t x, uint32_t y, uint32_t width,
                              uint32_t height, size_t stride) {
    ColorMoments moments;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            size_t at = clampTo(int(y) + dy, height) * stride + clampTo(int(x) + dx, width);
            float color[3] = {planes.color[0][at], planes.color[1][at], planes.color[2][at]};
            moments.add(color);
        }
    return moments;
}

// The inputs of one layer of one frame.
struct History {
    const Image& previous;
    const Image& flow; // pixels moved since the previous image: new position minus old one
    uint32_t factor;   // pixels of the planes for one of the flow, in each direction
    float scale[3];    // brings the previous image to the range of the planes
    float weight;
};

// Blends one pixel of `from` (colours, and the variance of their noise) with the previous image.
inline void blendPixel(const History& history, uint32_t x, uint32_t y, uint32_t width,
                       uint32_t height, size_t stride, const Planes& from, const Planes& to) {
    size_t at = y * stride + x;
    for (int c = 0; c < 3; ++c)
        to.color[c][at] = from.color[c][at];
    float moved[4] = {}, old[3];
    readPixel(history.flow, x / history.factor, y / history.factor, moved);
    moved[0] *= float(history.factor);
    moved[1] *= float(history.factor);
    if (!(__builtin_fabsf(moved[0]) < kLargestFlow && __builtin_fabsf(moved[1]) < kLargestFlow))
        return;
    float left = __builtin_floorf(-moved[0]), top = __builtin_floorf(-moved[1]);
    float fractionX = -moved[0] - left, fractionY = -moved[1] - top;
    int oldX = int(x) + int(left), oldY = int(y) + int(top);
    Reader reader{history.previous, history.scale};
    if (!reader.sample(oldX, oldY, fractionX, fractionY, old))
        return;
    ColorMoments now = momentsAt(from, x, y, width, height, stride);
    float noise = kNoisePart * from.variance[at];
    float rough = reader.around(oldX + (fractionX >= 0.5f), oldY + (fractionY >= 0.5f)).variance();
    float fit = (now.variance() + noise + kSmallVariance) / (rough + kSmallVariance);
    float trust = history.weight * std::min(1.0f, fit);
    for (int c = 0; c < 3; ++c) {
        float reach = kRange * __builtin_sqrtf(kChangePart * now.variance(c) + noise);
        float change = std::clamp(old[c] - from.color[c][at], -reach, reach);
        to.color[c][at] += change * trust;
    }
}

} // namespace sunstone::denoise
