// SPDX-License-Identifier: Apache-2.0
// Bodies of the row kernels; see rows.h. Include once in a file that is compiled for one
// instruction set: everything here is local to that file. A thread of a GPU runs the same bodies on
// chunks of one pixel (gpu/filter_kernels.cu), whose sums it keeps in registers.
#pragma once

#include "denoise/falloff.h"
#include "denoise/rows/rows.h"

#include <algorithm>

namespace sunstone::denoise {
namespace {

// A place in a plane, and a row of it. Threads of a GPU count in 32 bits, so that an address is one
// register plus the uniform address of a plane.
#if defined(__NVPTX__)
using Place = uint32_t;

// Otherwise the compiler keeps the values common to all rows of taps, for each column and plane, in
// more registers than exist.
inline uint32_t keptWhole(uint32_t place) {
    asm("" : "+r"(place));
    return place;
}

struct Row {
    const char* plane;
    uint32_t begin;

    Row() = default;
    Row(const float* plane, uint32_t begin)
        : plane(reinterpret_cast<const char*>(plane)), begin(begin) {}
    float operator[](uint32_t i) const {
        return *reinterpret_cast<const float*>(plane + uint64_t((begin + i) * 4u));
    }
};

// The row of a thread's own pixel: read once.
struct OwnRow {
    float value;

    OwnRow() = default;
    OwnRow(const float* plane, uint32_t begin, uint32_t x) : value(Row(plane, begin)[x]) {}
    float operator[](uint32_t) const { return value; }
};
#else
using Place = size_t;

struct Row {
    const float* begin;

    Row() = default;
    Row(const float* plane, size_t begin) : begin(plane + begin) {}
    float operator[](uint32_t i) const { return begin[i]; }
};

struct OwnRow : Row {
    OwnRow() = default;
    OwnRow(const float* plane, size_t begin, uint32_t) : Row(plane, begin) {}
};
#endif

// Squared distance of the guides of pixel i in row `at` and pixel j in row `other`.
template <int kGuides>
inline float guideDistance(const OwnRow* at, const Row* other, uint32_t i, uint32_t j) {
    float sum = 0.0f;
    for (int g = 0; g < kGuides; ++g) {
        float d = at[g][i] - other[g][j];
        sum += d * d;
    }
    return sum;
}

// Calls body(dx, dy, row of the tap, first, last): the pixels [first, last) of the chunk have a
// neighbour at (dx, dy) * step inside the image.
template <int kRadius, uint32_t kSize, class Body>
inline void forTaps(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end, int step,
                    Body body) {
    for (int dy = -kRadius; dy <= kRadius; ++dy) {
        const int row = int(y) + dy * step;
        if (row < 0 || row >= int(pass.height))
            continue;
        const Place at = Place(row) * Place(pass.stride);
#if defined(__NVPTX__)
#pragma unroll
        for (int dx = -kRadius; dx <= kRadius; ++dx) {
            const uint32_t x = begin + uint32_t(dx * step);
            if (x < pass.width)
                body(dx, dy, keptWhole(at + x) - x, begin, begin + 1);
        }
#else
        for (int dx = -kRadius; dx <= kRadius; ++dx) {
            const int shift = dx * step;
            const int first = std::max(int(begin), -shift);
            const int last = std::min(int(end), int(pass.width) - shift);
            if (first < last)
                body(dx, dy, at, uint32_t(first), uint32_t(last));
        }
#endif
    }
}

template <int kGuides>
struct GuideRows {
    Row rows[kGuides == 0 ? 1 : kGuides];
    GuideRows(const Pass& pass, Place begin) {
        for (int g = 0; g < kGuides; ++g)
            rows[g] = Row(pass.guides[g], begin);
    }
};
template <int kGuides>
struct OwnGuides {
    OwnRow rows[kGuides == 0 ? 1 : kGuides];
    OwnGuides(const Pass& pass, Place begin, uint32_t x) {
        for (int g = 0; g < kGuides; ++g)
            rows[g] = OwnRow(pass.guides[g], begin, x);
    }
};

inline float brightness(float r, float g, float b) {
    return 0.25f * r + 0.5f * g + 0.25f * b;
}

// A pixel may exceed the mean of its surroundings by this many standard deviations, both without
// the brightest pixel there: fireflies seldom occur alone.
constexpr float kFireflyDeviations = 5.0f;
// A pixel with fewer similar neighbours in total than this is hard to judge: it may be kSlack times
// brighter.
constexpr float kEnoughLikeness = 4.0f, kSlack = 10.0f;
constexpr float kLeastLikeness = 1e-3f; // keeps the sum positive if no neighbour is similar
constexpr float kSmall = 1e-6f;

template <int kGuides, uint32_t kSize>
inline void repairChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float weights[kSize] = {}, sums[5][kSize] = {}, top[kSize] = {}, topWeight[kSize] = {};
    const Place here = Place(y) * Place(pass.stride);
    const OwnGuides<kGuides> center(pass, here, begin);
    forTaps<kRepairRadius, kSize>(
        pass, y, begin, end, 1, [&](int dx, int dy, Place row, uint32_t first, uint32_t last) {
            if (dx == 0 && dy == 0)
                return;
            const GuideRows<kGuides> tap(pass, row);
            const Row r(pass.from.color[0], row);
            const Row g(pass.from.color[1], row);
            const Row b(pass.from.color[2], row);
            const Row valid(pass.valid, row);
            for (uint32_t x = first; x < last; ++x) {
                uint32_t q = uint32_t(int(x) + dx), i = x - begin;
                float like = falloff(guideDistance<kGuides>(center.rows, tap.rows, x, q));
                float w = valid[q] * (like + kLeastLikeness);
                float light = brightness(r[q], g[q], b[q]);
                weights[i] += w;
                sums[0][i] += w * r[q];
                sums[1][i] += w * g[q];
                sums[2][i] += w * b[q];
                sums[3][i] += w * light;
                sums[4][i] += w * light * light;
                bool brighter = w * light > top[i] * topWeight[i];
                top[i] = brighter ? light : top[i];
                topWeight[i] = brighter ? w : topWeight[i];
            }
        });
    for (uint32_t x = begin; x < end; ++x) {
        uint32_t i = x - begin;
        float weight = weights[i], inverse = weight > kSmall ? 1.0f / weight : 0.0f;
        float others = weight - topWeight[i], share = others > kSmall ? 1.0f / others : 0.0f;
        float mean = (sums[3][i] - topWeight[i] * top[i]) * share;
        float spread = (sums[4][i] - topWeight[i] * top[i] * top[i]) * share - mean * mean;
        float limit = mean + kFireflyDeviations * __builtin_sqrtf(spread > 0.0f ? spread : 0.0f);
        float color[3];
        for (int c = 0; c < 3; ++c)
            color[c] = pass.from.color[c][here + x];
        float light = brightness(color[0], color[1], color[2]);
        limit = weight > kEnoughLikeness ? limit : limit * kSlack;
        float cut = weight > kSmall && light > limit && light > kSmall ? limit / light : 1.0f;
        bool valid = pass.valid[here + x] != 0.0f;
        for (int c = 0; c < 3; ++c)
            pass.to.color[c][here + x] = valid ? color[c] * cut : sums[c][i] * inverse;
    }
}

template <int kGuides, uint32_t kSize>
inline void residualChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float weights[kSize] = {}, squares[kSize] = {}, sums[3][kSize] = {};
    const Place here = Place(y) * Place(pass.stride);
    const OwnGuides<kGuides> center(pass, here, begin);
    forTaps<kResidualRadius, kSize>(
        pass, y, begin, end, 1, [&](int dx, int, Place row, uint32_t first, uint32_t last) {
            const GuideRows<kGuides> tap(pass, row);
            const Row r(pass.from.color[0], row);
            const Row g(pass.from.color[1], row);
            const Row b(pass.from.color[2], row);
            for (uint32_t x = first; x < last; ++x) {
                uint32_t q = uint32_t(int(x) + dx), i = x - begin;
                float w = falloff(guideDistance<kGuides>(center.rows, tap.rows, x, q));
                weights[i] += w;
                squares[i] += w * w;
                sums[0][i] += w * r[q];
                sums[1][i] += w * g[q];
                sums[2][i] += w * b[q];
            }
        });
    for (uint32_t x = begin; x < end; ++x) {
        uint32_t i = x - begin;
        float inverse = 1.0f / weights[i]; // the pixel itself has weight 1
        float sum = 0.0f;
        for (int c = 0; c < 3; ++c) {
            float mean = sums[c][i] * inverse;
            float rest = pass.from.color[c][here + x] - mean;
            sum += rest * rest;
            pass.pilot.color[c][here + x] = mean;
        }
        pass.pilot.variance[here + x] = squares[i] * inverse * inverse;
        // A mean contains the pixel itself, with w0 = 1. The difference between independent noise
        // of variance v and the mean has the variance v * (1 - 2 w0 / W + sum w^2 / W^2).
        float kept = 1.0f - 2.0f * inverse + squares[i] * inverse * inverse;
        pass.to.variance[here + x] = kept > 0.1f ? sum / kept : sum;
    }
}

template <int kGuides, uint32_t kSize>
inline void spreadChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float weights[kSize] = {}, sums[kSize] = {};
    const Place here = Place(y) * Place(pass.stride);
    const OwnGuides<kGuides> center(pass, here, begin);
    forTaps<kSpreadRadius, kSize>(
        pass, y, begin, end, 1, [&](int dx, int dy, Place row, uint32_t first, uint32_t last) {
            if ((dx + dy) % 2 != 0) // every other pixel suffices
                return;
            const GuideRows<kGuides> tap(pass, row);
            const Row variance(pass.from.variance, row);
            for (uint32_t x = first; x < last; ++x) {
                uint32_t q = uint32_t(int(x) + dx), i = x - begin;
                float w = falloff(guideDistance<kGuides>(center.rows, tap.rows, x, q));
                weights[i] += w;
                sums[i] += w * variance[q];
            }
        });
    for (uint32_t x = begin; x < end; ++x) {
        float variance = sums[x - begin] / weights[x - begin];
        pass.to.variance[here + x] = variance;
        pass.pilot.variance[here + x] *= variance;
    }
}

} // namespace
} // namespace sunstone::denoise

#include "denoise/rows/rows_detail.h"
#include "denoise/rows/rows_return.h"

namespace sunstone::denoise {
namespace {

inline float splineAt(int d) {
    return d == 0 ? 3.0f / 8.0f : d == 1 || d == -1 ? 1.0f / 4.0f : 1.0f / 16.0f;
}
constexpr float kLeastVariance = 1e-9f;

template <int kGuides, bool kAlpha, uint32_t kSize>
inline void smoothChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float weights[kSize] = {}, sums[5][kSize] = {};
    const Place here = Place(y) * Place(pass.stride);
    const OwnGuides<kGuides> center(pass, here, begin);
    const OwnRow r0(pass.pilot.color[0], here, begin);
    const OwnRow g0(pass.pilot.color[1], here, begin);
    const OwnRow b0(pass.pilot.color[2], here, begin);
    const OwnRow v0(pass.pilot.variance, here, begin);
    forTaps<2, kSize>(pass, y, begin, end, pass.step,
                      [&](int dx, int dy, Place row, uint32_t first, uint32_t last) {
                          const GuideRows<kGuides> tap(pass, row);
                          const Row r(pass.from.color[0], row);
                          const Row g(pass.from.color[1], row);
                          const Row b(pass.from.color[2], row);
                          const Row v(pass.from.variance, row);
                          const Row pr(pass.pilot.color[0], row);
                          const Row pg(pass.pilot.color[1], row);
                          const Row pb(pass.pilot.color[2], row);
                          const Row pv(pass.pilot.variance, row);
                          const Row alpha(kAlpha ? pass.from.alpha : pass.from.variance, row);
                          float spline = splineAt(dx) * splineAt(dy);
                          int shift = dx * pass.step;
                          for (uint32_t x = first; x < last; ++x) {
                              uint32_t q = uint32_t(int(x) + shift), i = x - begin;
                              float dr = pr[q] - r0[x], dg = pg[q] - g0[x], db = pb[q] - b0[x];
                              float noise = v0[x] + pv[q];
                              float beyond = dr * dr + dg * dg + db * db - noise;
                              beyond = beyond > 0.0f ? beyond : 0.0f;
                              float distance =
                                  beyond / (pass.colorTolerance * noise + kLeastVariance) +
                                  guideDistance<kGuides>(center.rows, tap.rows, x, q);
                              float w = spline * falloff(distance);
                              weights[i] += w;
                              sums[0][i] += w * r[q];
                              sums[1][i] += w * g[q];
                              sums[2][i] += w * b[q];
                              sums[3][i] += w * w * v[q];
                              if constexpr (kAlpha)
                                  sums[4][i] += w * alpha[q];
                          }
                      });
    for (uint32_t x = begin; x < end; ++x) {
        uint32_t i = x - begin;
        float inverse = 1.0f / weights[i]; // the pixel itself has a weight
        for (int c = 0; c < 3; ++c)
            pass.to.color[c][here + x] = sums[c][i] * inverse;
        pass.to.variance[here + x] = sums[3][i] * inverse * inverse;
        if constexpr (kAlpha)
            pass.to.alpha[here + x] = sums[4][i] * inverse;
    }
}

} // namespace
} // namespace sunstone::denoise
