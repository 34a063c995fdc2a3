// SPDX-License-Identifier: Apache-2.0
#include "denoise/upsampler.h"

#include "denoise/falloff.h"

#include <algorithm>
#include <cmath>

namespace sunstone::denoise {
namespace {

// Weight of guides, in units of their tolerance, beside compressed colours in the tensor.
constexpr float kGuidePart = 0.01f;
// Gradient, squared, from which an edge counts in full; and what noise may make of it.
constexpr float kEdge = 0.002f, kNoise = 0.0005f;
// The Gaussian: 1 / (2 sigma^2) across an edge (sigma 0.45 pixels of the input), how much narrower
// a full edge makes it across and how much wider, in variances, along.
constexpr float kSharpness = 2.47f, kNarrower = 0.5f, kLonger = 5.0f;
constexpr float kLeastShare = 1.0f / 256;

// Catmull-Rom at a quarter of a pixel: the pixel before, itself, the next two.
constexpr float kCubic[4] = {-0.0703125f, 0.8671875f, 0.2265625f, -0.0234375f};

float compress(float value) {
    return std::copysign(std::sqrt(std::sqrt(std::abs(value))), value);
}
float expand(float value) {
    float square = value * value;
    return std::copysign(square * square, value);
}

size_t clampTo(int64_t value, uint32_t size) {
    return size_t(std::clamp<int64_t>(value, 0, int64_t(size) - 1));
}

// Direction and strength of the edge in a pixel.
struct Edge {
    float cosine = 0, sine = 0; // of twice the angle of the direction across
    float share = 0;            // 0: none, 1: sharp
};

Edge edgeAt(const Upsampler& u, uint32_t x, uint32_t y) {
    float sums[3] = {};
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            size_t at =
                clampTo(int64_t(y) + dy, u.height) * u.stride + clampTo(int64_t(x) + dx, u.width);
            float w = float((2 - std::abs(dx)) * (2 - std::abs(dy))) * 0.0625f;
            for (int i = 0; i < 3; ++i)
                sums[i] += w * u.tensor[i][at];
        }
    float difference = sums[0] - sums[2], mixed = 2.0f * sums[1], sum = sums[0] + sums[2];
    float length = std::sqrt(difference * difference + mixed * mixed);
    Edge edge;
    if (length > 0.0f) {
        edge.cosine = difference / length;
        edge.sine = mixed / length;
        edge.share = std::min(1.0f, sum / kEdge) * length / (sum + kNoise);
    }
    return edge;
}

// One successor of pixel (x, y), on its side (right, down) of it; each -1 or 1.
void interpolate(const Upsampler& u, uint32_t x, uint32_t y, int right, int down, const Edge& edge,
                 float (&result)[3]) {
    bool isSteered = edge.share > kLeastShare;
    float across = kSharpness * (1.0f + kNarrower * edge.share);
    float along = kSharpness / (1.0f + kLonger * edge.share);
    float weight = 0.0f, steered[3] = {}, cubic[3] = {}, low[3], high[3];
    for (int j = 0; j < 4; ++j) {
        size_t row = clampTo(int64_t(y) + down * (j - 1), u.height) * u.stride;
        for (int i = 0; i < 4; ++i) {
            size_t at = row + clampTo(int64_t(x) + right * (i - 1), u.width);
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

} // namespace

void Upsampler::compressRow(uint32_t y) const {
    for (int c = 0; c < 3; ++c)
        for (size_t at = y * stride; at < y * stride + width; ++at)
            compressed[c][at] = compress(color[c][at]);
}

void Upsampler::tensorRow(uint32_t y) const {
    size_t above = clampTo(int64_t(y) - 1, height) * stride, here = y * stride,
           below = clampTo(int64_t(y) + 1, height) * stride;
    for (uint32_t x = 0; x < width; ++x) {
        size_t left = clampTo(int64_t(x) - 1, width), right = clampTo(int64_t(x) + 1, width);
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
        for (const float* plane : compressed)
            add(plane, 1.0f);
        for (int g = 0; g < guideCount; ++g)
            add(guides[g], kGuidePart);
        for (int i = 0; i < 3; ++i)
            tensor[i][here + x] = sums[i];
    }
}

void Upsampler::upsampleRow(uint32_t y) const {
    for (uint32_t x = 0; x < width; ++x) {
        Edge edge = edgeAt(*this, x, y);
        for (uint32_t j = 0; j < 2; ++j)
            for (uint32_t i = 0; i < 2; ++i) {
                float result[3];
                interpolate(*this, x, y, i ? 1 : -1, j ? 1 : -1, edge, result);
                size_t at = (2 * size_t(y) + j) * outputStride + 2 * size_t(x) + i;
                for (int c = 0; c < 3; ++c)
                    to.color[c][at] = result[c];
                to.variance[at] = variance[y * stride + x];
            }
    }
}

} // namespace sunstone::denoise
