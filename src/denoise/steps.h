// SPDX-License-Identifier: Apache-2.0
// The steps of job.h other than row kernels, for one pixel. Compiled for CPUs and for threads of
// GPUs with the same bits as the result: no sum depends on the order of pixels, and nothing is
// fused.
#pragma once

#include "denoise/history.h"
#include "denoise/job.h"
#include "denoise/structure.h"
#include "denoise/tone_map.h"

#include <algorithm>

namespace sunstone::denoise {

// Larger values count as infinite; the square of this one still fits into a float.
constexpr float kLargestColor = 1e8f;
// Below this albedo colours count gradually as emitted or mirrored instead of diffuse. The same
// holds for pixels at the silhouette of an object before the sky.
constexpr float kDarkAlbedo = 0.2f;
constexpr float kLeastDivisor = 0.02f;

// Limited colours are encoded for a screen. The mean of noisy encoded colours is too dark, so they
// are averaged as light, by a curve that is close to all common encodings. A screen shows nothing
// above 1: larger values would dominate their neighbours.
inline float decoded(float value) {
    return value > 0.0f ? std::min(value * value, 1.0f) : 0.0f;
}
inline float encoded(float value) {
    return value > 0.0f ? __builtin_sqrtf(value) : 0.0f;
}

inline bool isUsable(float value) {
    return __builtin_fabsf(value) < __builtin_inff(); // false for NaN
}

inline float scaleOf(const Job& job, int channel) {
    return job.isScaled ? job.control->scale[channel] : 1.0f;
}

// Albedos are compared by contrast: the distance from 0.02 to 0.1 equals that from 0.3 to 0.8.
// Without this, dark textures would be averaged.
constexpr float kDarkStretch = 0.6f, kStretchedAlbedo = 0.06f;
inline float stretchedAlbedo(float albedo) {
    return albedo + kDarkStretch * albedo / (albedo + kStretchedAlbedo);
}
// Its inverse.
inline float plainAlbedo(float stretched) {
    const float half = 0.5f * (kStretchedAlbedo + kDarkStretch - stretched);
    return __builtin_sqrtf(half * half + stretched * kStretchedAlbedo) - half;
}

// The divisor of diffuse colours, for one pixel.
struct Divisor {
    float values[3];

    Divisor(const Job& job, size_t at) {
        float albedo[3];
        for (int c = 0; c < 3; ++c)
            albedo[c] = plainAlbedo(job.pass.guides[c][at] * job.albedoTolerance);
        float brightest = std::max(albedo[0], std::max(albedo[1], albedo[2]));
        float diffuse = std::min(1.0f, brightest / kDarkAlbedo);
        for (int c = 0; c < 3; ++c)
            values[c] = std::max(albedo[c], kLeastDivisor) * diffuse + (1.0f - diffuse);
    }
};

// Guide planes hold values divided by their tolerance, so that the kernels add up squares.
inline void loadGuide(const Job& job, const Image& image, int channels, float tolerance,
                      float least, int plane, uint32_t x, uint32_t y) {
    float values[4] = {};
    readPixel(image, x, y, values);
    forChannels(unsigned(channels), [&](unsigned c) {
        float value = isUsable(values[c]) ? values[c] : 0.0f;
        value = std::clamp(value, least, 1.0f);
        if (least == 0.0f) // an albedo
            value = stretchedAlbedo(value);
        job.guides[plane + int(c)][y * job.pass.stride + x] = value / tolerance;
    });
}
inline void loadGuides(const Job& job, uint32_t x, uint32_t y) {
    if (job.albedo)
        loadGuide(job, job.albedo, 3, job.albedoTolerance, 0.0f, 0, x, y);
    if (job.normal)
        loadGuide(job, job.normal, job.normalChannels, job.normalTolerance, -1.0f,
                  job.albedo ? 3 : 0, x, y);
}

inline void loadAlpha(const Job& job, uint32_t x, uint32_t y) {
    float values[4] = {};
    readPixel(job.input, x, y, values);
    bool keep = job.keepsAlpha || isUsable(values[3]);
    job.alpha[y * job.pass.stride + x] = keep ? values[3] : 1.0f;
}

// Alpha as a separate image, with the same guides.
inline void alphaAsColor(const Job& job, uint32_t x, uint32_t y) {
    size_t at = y * job.pass.stride + x;
    job.valid[at] = 1.0f;
    job.pass.to.color[0][at] = std::clamp(job.alpha[at], -kLargestColor, kLargestColor);
    job.pass.to.color[1][at] = 0.0f;
    job.pass.to.color[2][at] = 0.0f;
}
inline void colorAsAlpha(const Job& job, uint32_t x, uint32_t y) {
    size_t at = y * job.pass.stride + x;
    job.alpha[at] = job.pass.from.color[0][at];
}

inline void loadColor(const Job& job, uint32_t x, uint32_t y) {
    size_t at = y * job.pass.stride + x;
    float values[4] = {};
    readPixel(job.input, x, y, values);
    bool usable = isUsable(values[0]) && isUsable(values[1]) && isUsable(values[2]);
    job.valid[at] = usable ? 1.0f : 0.0f;
    float divisors[3] = {1.0f, 1.0f, 1.0f};
    if (job.isDivided) {
        Divisor divisor(job, at);
        for (int c = 0; c < 3; ++c)
            divisors[c] = divisor.values[c];
    }
    for (int c = 0; c < 3; ++c) {
        float value = usable ? values[c] : 0.0f;
        value = job.isLimited ? decoded(value) : value * scaleOf(job, c) / divisors[c];
        job.pass.to.color[c][at] = std::clamp(value, -kLargestColor, kLargestColor);
    }
}

inline void restoreColor(const Job& job, uint32_t x, uint32_t y) {
    const Planes& planes = job.pass.from;
    size_t at = y * job.pass.stride + x;
    if (job.hasDetail)
        for (int c = 0; c < 3; ++c)
            planes.color[c][at] += job.pass.detail[c][at];
    if (!job.isDivided)
        return;
    Divisor divisor(job, at);
    float largest = 0.0f;
    for (int c = 0; c < 3; ++c) {
        planes.color[c][at] *= divisor.values[c];
        largest = std::max(largest, divisor.values[c]);
    }
    planes.variance[at] *= largest * largest;
}

inline void blendHistory(const Job& job, uint32_t x, uint32_t y) {
    History history{job.previous,
                    job.flow,
                    job.factor,
                    {scaleOf(job, 0), scaleOf(job, 1), scaleOf(job, 2)},
                    job.historyWeight};
    blendPixel(history, x, y, job.factor * job.pass.width, job.factor * job.pass.height,
               job.outputStride, job.pass.from, job.pass.to);
}

// Bilinear, at a pixel of an output twice as large.
inline float alphaBetween(const Job& job, uint32_t x, uint32_t y) {
    auto other = [](uint32_t large, uint32_t size) {
        uint32_t own = large / 2;
        return large % 2 ? std::min(own + 1, size - 1) : own - std::min(own, 1u);
    };
    size_t row = y / 2 * job.pass.stride, otherRow = other(y, job.pass.height) * job.pass.stride;
    size_t column = x / 2, otherColumn = other(x, job.pass.width);
    const float* alpha = job.alpha;
    return 0.75f * (0.75f * alpha[row + column] + 0.25f * alpha[row + otherColumn]) +
           0.25f * (0.75f * alpha[otherRow + column] + 0.25f * alpha[otherRow + otherColumn]);
}

// (x, y) of the output.
inline void writeColor(const Job& job, uint32_t x, uint32_t y) {
    uint32_t largeX = x + job.factor * job.offsetX, largeY = y + job.factor * job.offsetY;
    size_t at = size_t(largeY) * job.outputStride + largeX;
    float values[4] = {0, 0, 0, 1};
    for (int c = 0; c < 3; ++c) {
        float value = job.pass.from.color[c][at];
        values[c] = job.isLimited ? std::min(encoded(value), 1.0f) : value / scaleOf(job, c);
    }
    if (channelsOf(job.input.format) == 4)
        values[3] = job.factor == 1 ? job.alpha[at] : alphaBetween(job, largeX, largeY);
    if (job.blend != 0.0f) {
        float given[4] = {0, 0, 0, 1};
        readPixel(job.input, largeX / job.factor, largeY / job.factor, given);
        for (int c = 0; c < 4; ++c)
            if (isUsable(given[c])) // the difference from a larger value would lose digits
                values[c] =
                    job.blend == 1.0f ? given[c] : values[c] + (given[c] - values[c]) * job.blend;
    }
    writePixel(job.output, x, y, values);
}

// ---- Steps of other filters --------------------------------------------------------------------

inline void toneMap(const Job& job, uint32_t x, uint32_t y) {
    float values[4] = {0, 0, 0, 1};
    readPixel(job.input, x, y, values);
    float mapped[4];
    for (int c = 0; c < 4; ++c) // four at once cost as much as three
        mapped[c] = toneMapped(values[c] * job.exposure, job.inverseGamma);
    mapped[3] = values[3];
    writePixel(job.output, x, y, mapped);
}

// The brightness of a pixel to the eye, 0 to 1.
inline float brightnessOf(const Job& job, const Image& image, uint32_t x, uint32_t y) {
    float c[4] = {};
    readPixel(image, x, y, c);
    const float luminance = c[0] * 0.212586f + c[1] * 0.715170f + c[2] * 0.072200f;
    if (!(luminance > 0.0f)) // NaN too
        return 0.0f;
    if (job.isLimited)
        return std::min(luminance, 1.0f);
    const float scaled = std::min(luminance, kLargestColor) * scaleOf(job, 0);
    return scaled / (1.0f + scaled);
}

// (x, y) of the output: a block of kStructureBlock pixels in each direction, less at the border.
inline void compareStructure(const Job& job, uint32_t x, uint32_t y) {
    const uint32_t left = x * kStructureBlock, top = y * kStructureBlock;
    const uint32_t right = std::min(left + kStructureBlock, job.input.width);
    const uint32_t bottom = std::min(top + kStructureBlock, job.input.height);
    StructureSums sums;
    for (uint32_t py = top; py < bottom; ++py)
        for (uint32_t px = left; px < right; ++px)
            sums.add(brightnessOf(job, job.input, px, py), brightnessOf(job, job.previous, px, py));
    const float similarity = sums.similarity();
    const float values[4] = {similarity, similarity, similarity, 1.0f};
    writePixel(job.output, x, y, values);
}

} // namespace sunstone::denoise
