// SPDX-License-Identifier: Apache-2.0
// The row kernels that detect where the passes removed more than noise, and restore that part; part
// of rows_body.h, whose helpers it uses.
//
// Noise of neighbouring pixels is independent. The difference between the given picture and the
// smoothed one should therefore be white: where neighbours' differences are alike, they hold
// structure that no guide shows (a glowing pattern, a shadow, a thin object). The covariance of
// neighbours at distances of one and two pixels, extrapolated to distance 0, is the structure's
// variance (Thong, Sim, Phang 2001, "Single-image signal-to-noise ratio estimation"). That share of
// the difference returns.
//
// This measure takes structure that is finer than two pixels, or sparse (the rim of an object), for
// noise. But noise is uniform in a neighbourhood: where the differences in a box around the pixel
// are several times those of the quietest box beside it, the difference returns, too.
#include "denoise/rows/rows.h"

namespace sunstone::denoise {
namespace {

// The part of the difference's variance that is structure. From the first value on the difference
// begins to return, from the second on all of it returns. Noise alone seldom reaches the first.
constexpr float kLeastStructure = 0.2f, kFullStructure = 0.6f;
// Boxes of equal noise may differ by this factor, because noise has outliers.
constexpr float kNoiseAround = 7.0f;
// Squared error that the passes leave anywhere, relative to the light: smaller noise is ignored.
constexpr float kUsualLoss = 0.0005f;
constexpr float kMostLoss = 2.0f; // relative to the smoothed light: limits the effect of one pixel

// pilot (the given picture), from (the smoothed one) -> to.color[0]: their difference, relative
template <uint32_t kSize>
inline void lossChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    const Place here = Place(y) * Place(pass.stride);
    for (uint32_t x = begin; x < end; ++x) {
        const size_t at = here + x;
        const float smooth =
            brightness(pass.from.color[0][at], pass.from.color[1][at], pass.from.color[2][at]);
        const float given =
            brightness(pass.pilot.color[0][at], pass.pilot.color[1][at], pass.pilot.color[2][at]);
        const float scale = smooth > kSmallLight ? smooth : kSmallLight;
        const float loss = (given - smooth) / scale;
        pass.to.color[0][at] = std::clamp(loss, -kMostLoss, kMostLoss);
    }
}

// to.color[0] -> to.color[1]: its square; to.color[2], to.variance: structure along rows, columns
template <uint32_t kSize>
inline void correlateChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float sums[4][kSize] = {}, counts[4][kSize] = {}; // rows: distance 1, 2; columns
    const Place here = Place(y) * Place(pass.stride);
    const OwnRow own(pass.to.color[0], here, begin);
    forTaps<kCorrelateRadius, kSize>(
        pass, y, begin, end, 1, [&](int dx, int dy, Place row, uint32_t first, uint32_t last) {
            if ((dx == 0) == (dy == 0))
                return;
            const int which = (dx == 0 ? 2 : 0) + ((dx + dy) % 2 == 0 ? 1 : 0);
            const Row other(pass.to.color[0], row);
            for (uint32_t x = first; x < last; ++x) {
                sums[which][x - begin] += own[x] * other[uint32_t(int(x) + dx)];
                counts[which][x - begin] += 1.0f;
            }
        });
    for (uint32_t x = begin; x < end; ++x) {
        const uint32_t i = x - begin;
        float means[4];
        for (int k = 0; k < 4; ++k)
            means[k] = sums[k][i] / (counts[k][i] > 0.0f ? counts[k][i] : 1.0f);
        pass.to.color[1][here + x] = own[x] * own[x];
        pass.to.color[2][here + x] = 2.0f * means[0] - means[1];
        pass.to.variance[here + x] = 2.0f * means[2] - means[3];
    }
}

// to.color[1], to.color[2], to.variance -> to.color[0], sums: sums over a row
template <uint32_t kSize>
inline void gatherChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    const Place here = Place(y) * Place(pass.stride);
    float sums[3][kSize] = {};
    const Row rows[3] = {Row(pass.to.color[1], here), Row(pass.to.color[2], here),
                         Row(pass.to.variance, here)};
    for (int dx = -kGatherRadius; dx <= kGatherRadius; ++dx) {
        const uint32_t first = uint32_t(std::max(int(begin), -dx));
        const uint32_t last = uint32_t(std::max(0, std::min(int(end), int(pass.width) - dx)));
        for (uint32_t x = first; x < last; ++x)
            for (int k = 0; k < 3; ++k)
                sums[k][x - begin] += rows[k][uint32_t(int(x) + dx)];
    }
    for (uint32_t x = begin; x < end; ++x) {
        pass.to.color[0][here + x] = sums[0][x - begin];
        pass.sums[0][here + x] = sums[1][x - begin];
        pass.sums[1][here + x] = sums[2][x - begin];
    }
}

// to.color[1] -> to.color[2]: sums over a box's part of a row
template <uint32_t kSize>
inline void sumRowChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    const Place here = Place(y) * Place(pass.stride);
    float sums[kSize] = {};
    const Row row(pass.to.color[1], here);
    for (int dx = -kBoxRadius; dx <= kBoxRadius; ++dx) {
        const uint32_t first = uint32_t(std::max(int(begin), -dx));
        const uint32_t last = uint32_t(std::max(0, std::min(int(end), int(pass.width) - dx)));
        for (uint32_t x = first; x < last; ++x)
            sums[x - begin] += row[uint32_t(int(x) + dx)];
    }
    for (uint32_t x = begin; x < end; ++x)
        pass.to.color[2][here + x] = sums[x - begin];
}

// Number of pixels of a row or column within `radius` of a place.
inline int pixelsAround(uint32_t at, uint32_t size, int radius) {
    return std::min(int(at), radius) + std::min(int(size) - 1 - int(at), radius) + 1;
}

// to.color[2] -> to.variance: mean of the box around a pixel
template <uint32_t kSize>
inline void meanOfBoxChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    const Place here = Place(y) * Place(pass.stride);
    float sums[kSize] = {};
    for (int dy = -kBoxRadius; dy <= kBoxRadius; ++dy) {
        const int row = int(y) + dy;
        if (row < 0 || row >= int(pass.height))
            continue;
        const Row other(pass.to.color[2], Place(row) * Place(pass.stride));
        for (uint32_t x = begin; x < end; ++x)
            sums[x - begin] += other[x];
    }
    const int rows = pixelsAround(y, pass.height, kBoxRadius);
    for (uint32_t x = begin; x < end; ++x)
        pass.to.variance[here + x] =
            sums[x - begin] / float(rows * pixelsAround(x, pass.width, kBoxRadius));
}

// The centre of a box that lies inside the image, where the image is large enough.
inline uint32_t boxCentre(int at, uint32_t size) {
    return uint32_t(std::max(std::min(std::max(at, kBoxRadius), int(size) - 1 - kBoxRadius), 0));
}

// The part of the differences around a pixel that cannot be noise, because the quietest of four
// boxes beside it has less.
struct Boxes {
    Row own, above, below; // means, by rows of centres
    uint32_t width;

    Boxes(const Pass& pass, uint32_t y) : width(pass.width) {
        const auto rowAt = [&](int at) {
            return Row(pass.to.variance, Place(boxCentre(at, pass.height)) * Place(pass.stride));
        };
        own = rowAt(int(y));
        above = rowAt(int(y) - kBoxDistance);
        below = rowAt(int(y) + kBoxDistance);
    }
    float structure(uint32_t x) const {
        const uint32_t left = boxCentre(int(x) - kBoxDistance, width),
                       right = boxCentre(int(x) + kBoxDistance, width);
        const float quietest =
            std::min(std::min(above[left], above[right]), std::min(below[left], below[right]));
        const float mean = own[boxCentre(int(x), width)];
        return mean > kSmall * kSmall ? 1.0f - kNoiseAround * quietest / mean : 0.0f;
    }
};

// The planes of gatherChunk and meanOfBoxChunk, from, pilot -> from
template <uint32_t kSize>
inline void returnChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    const Place here = Place(y) * Place(pass.stride);
    const Boxes boxes(pass, y);
    float sums[3][kSize] = {};
    for (int dy = -kGatherRadius; dy <= kGatherRadius; ++dy) {
        const int row = int(y) + dy;
        if (row < 0 || row >= int(pass.height))
            continue;
        const Place at = Place(row) * Place(pass.stride);
        const Row rows[3] = {Row(pass.to.color[0], at), Row(pass.sums[0], at),
                             Row(pass.sums[1], at)};
        for (uint32_t x = begin; x < end; ++x)
            for (int k = 0; k < 3; ++k)
                sums[k][x - begin] += rows[k][x];
    }
    for (uint32_t x = begin; x < end; ++x) {
        const uint32_t i = x - begin;
        const float structure = std::max(sums[1][i], 0.0f) + std::max(sums[2][i], 0.0f);
        const float across = float(pixelsAround(x, pass.width, kGatherRadius));
        const float down = float(pixelsAround(y, pass.height, kGatherRadius));
        const float total = sums[0][i] + kSmall;
        const float part = structure / total + kUsualLoss * across * down / total;
        const float returned = std::max(
            (part - kLeastStructure) / (kFullStructure - kLeastStructure), boxes.structure(x));
        const float share = pass.mostReturned * std::clamp(returned, 0.0f, 1.0f);
        for (int c = 0; c < 3; ++c) {
            float& smooth = pass.from.color[c][here + x];
            smooth += (pass.pilot.color[c][here + x] - smooth) * share;
        }
    }
}

} // namespace
} // namespace sunstone::denoise
