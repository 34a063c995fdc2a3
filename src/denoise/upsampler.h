// SPDX-License-Identifier: Apache-2.0
// Makes a denoised image twice as wide and high. All images have the size of the input, so no finer
// guide exists; the images only give the position and direction of edges.
//
//   1. Colours are compressed (fourth roots), so that a lamp does not outshine its neighbourhood.
//   2. The structure tensor of colours and guides gives direction and strength of edges.
//   3. A pixel's four successors are interpolated by a cubic without overshoot away from edges, and
//      at edges by a Gaussian kernel stretched along the edge (steering kernels: Takeda, Farsiu,
//      Milanfar 2007), which removes steps and noise from edges.
//
// A pixel depends on inputs within kUpsamplerRadius. Compiled for CPUs and for threads of GPUs.
#pragma once

#include "denoise/falloff.h"
#include "denoise/image.h"
#include "denoise/rows/rows.h"

namespace sunstone::denoise {

constexpr int kUpsamplerRadius = 2;

struct Upsampler {
    uint32_t width, height; // of the input
    size_t stride;          // of the input's planes, in floats
    int guideCount;
    const float* guides[kMaxGuides]; // in units of their tolerance
    const float* color[3];
    const float* variance;
    float* compressed[3]; // scratch, planes like the input's
    float* tensor[3];     // likewise
    size_t outputStride;
    Planes to; // colours and variance of twice the width and height
};

// Weight of guides, in units of their tolerance, beside compressed colours in the tensor.
constexpr float kGuidePart = 0.01f;
// Squared gradient from which an edge counts in full; and the part that noise may cause.
constexpr float kEdge = 0.002f, kNoise = 0.0005f;
// The Gaussian: 1 / (2 sigma^2) across an edge (sigma 0.45 pixels of the input), how much narrower
// a full edge makes it across and how much wider, in variances, along.
constexpr float kSharpness = 2.47f, kNarrower = 0.5f, kLonger = 5.0f;
constexpr float kLeastShare = 1.0f / 256;

// Catmull-Rom at a quarter of a pixel: the pixel before, itself, the next two.
constexpr float kCubic[4] = {-0.0703125f, 0.8671875f, 0.2265625f, -0.0234375f};

inline float compress(float value) {
    return __builtin_copysignf(__builtin_sqrtf(__builtin_sqrtf(__builtin_fabsf(value))), value);
}
inline float expand(float value) {
    float square = value * value;
    return __builtin_copysignf(square * square, value);
}

// Direction and strength of the edge in a pixel.
struct Edge {
    float cosine = 0, sine = 0; // of twice the angle of the direction across
    float share = 0;            // 0: none, 1: sharp
};

inline Edge edgeAt(const Upsampler& u, uint32_t x, uint32_t y) {
    float sums[3] = {};
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            size_t at = clampTo(int(y) + dy, u.height) * u.stride + clampTo(int(x) + dx, u.width);
            float w = float((dx ? 1 : 2) * (dy ? 1 : 2)) * 0.0625f;
            for (int i = 0; i < 3; ++i)
                sums[i] += w * u.tensor[i][at];
        }
    float difference = sums[0] - sums[2], mixed = 2.0f * sums[1], sum = sums[0] + sums[2];
    float length = __builtin_sqrtf(difference * difference + mixed * mixed);
    Edge edge;
    if (length > 0.0f) {
        edge.cosine = difference / length;
        edge.sine = mixed / length;
        edge.share = std::min(1.0f, sum / kEdge) * length / (sum + kNoise);
    }
    return edge;
}

// One successor of pixel (x, y), on its side (right, down) of it; each -1 or 1.
inline void interpolate(const Upsampler& u, uint32_t x, uint32_t y, int right, int down,
                        const Edge& edge, float (&result)[3]) {
    bool isSteered = edge.share > kLeastShare;
    float across = kSharpness * (1.0f + kNarrower * edge.share);
    float along = kSharpness / (1.0f + kLonger * edge.share);
    float weight = 0.0f, steered[3] = {}, cubic[3] = {}, low[3], high[3];
    for (int j = 0; j < 4; ++j) {
        size_t row = clampTo(int(y) + down * (j - 1), u.height) * u.stride;
        for (int i = 0; i < 4; ++i) {
            size_t at = row + clampTo(int(x) + right * (i - 1), u.width);
            float w = 0.0f;
            if (isSteered) {
                float dx = float(right) * (float(i) - 1.25f), dy = float(down) * (float(j) - 1.25f);
                float square = dx * dx + dy * dy;
                float turned = (dx * dx - dy * dy) * edge.cosine + 2.0f * dx * dy * edge.sine;
                w = falloff(0.5f *
                            std::max(0.0f, (square + turned) * across + (square - turned) * along));
                weight += w;
            }
            bool isNear = (i == 1 || i == 2) && (j == 1 || j == 2), isFirst = i == 1 && j == 1;
            for (int c = 0; c < 3; ++c) {
                float value = u.compressed[c][at];
                steered[c] += w * value;
                cubic[c] += kCubic[i] * kCubic[j] * value;
                if (isNear) {
                    low[c] = isFirst ? value : std::min(low[c], value);
                    high[c] = isFirst ? value : std::max(high[c], value);
                }
            }
        }
    }
    for (int c = 0; c < 3; ++c) {
        float value = std::clamp(cubic[c], low[c], high[c]);
        if (isSteered)
            value += (steered[c] / weight - value) * edge.share;
        result[c] = expand(value);
    }
}

// The three steps for pixel (x, y) of the input, each for all pixels, one after the other.
inline void compressPixel(const Upsampler& u, uint32_t x, uint32_t y) {
    size_t at = y * u.stride + x;
    for (int c = 0; c < 3; ++c)
        u.compressed[c][at] = compress(u.color[c][at]);
}

inline void tensorPixel(const Upsampler& u, uint32_t x, uint32_t y) {
    size_t above = clampTo(int(y) - 1, u.height) * u.stride, here = y * u.stride,
           below = clampTo(int(y) + 1, u.height) * u.stride;
    size_t left = clampTo(int(x) - 1, u.width), right = clampTo(int(x) + 1, u.width);
    float sums[3] = {};
    auto add = [&](const float* plane, float part) {
        float a = plane[above + left], b = plane[above + right], c = plane[below + left],
              d = plane[below + right];
        float dx = (b + 2.0f * plane[here + right] + d - a - 2.0f * plane[here + left] - c);
        float dy = (c + 2.0f * plane[below + x] + d - a - 2.0f * plane[above + x] - b);
        part *= 1.0f / 64; // of the eighth that makes them differences of one pixel
        sums[0] += part * dx * dx;
        sums[1] += part * dx * dy;
        sums[2] += part * dy * dy;
    };
    for (const float* plane : u.compressed)
        add(plane, 1.0f);
    for (int g = 0; g < u.guideCount; ++g)
        add(u.guides[g], kGuidePart);
    for (int i = 0; i < 3; ++i)
        u.tensor[i][here + x] = sums[i];
}

// Writes four pixels of the output.
inline void upsamplePixel(const Upsampler& u, uint32_t x, uint32_t y) {
    Edge edge = edgeAt(u, x, y);
    for (uint32_t j = 0; j < 2; ++j)
        for (uint32_t i = 0; i < 2; ++i) {
            float result[3];
            interpolate(u, x, y, i ? 1 : -1, j ? 1 : -1, edge, result);
            size_t at = (2 * size_t(y) + j) * u.outputStride + 2 * size_t(x) + i;
            for (int c = 0; c < 3; ++c)
                u.to.color[c][at] = result[c];
            u.to.variance[at] = u.variance[y * u.stride + x];
        }
}

} // namespace sunstone::denoise
