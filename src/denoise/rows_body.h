// SPDX-License-Identifier: Apache-2.0
// Bodies of the row kernels; see rows.h. Include once in a file that is compiled for one
// instruction set: everything here is local to that file.
#include "denoise/falloff.h"
#include "denoise/rows.h"

#include <algorithm>
#include <cmath>

namespace sunstone::denoise {
namespace {

constexpr uint32_t kChunk = 256; // pixels whose sums are held on the stack

// Squared distance of the guides of pixel i in row `at` and pixel j in row `other`.
template <int kGuides>
inline float guideDistance(const float* const* at, const float* const* other, uint32_t i,
                           uint32_t j) {
    float sum = 0.0f;
    for (int g = 0; g < kGuides; ++g) {
        float d = at[g][i] - other[g][j];
        sum += d * d;
    }
    return sum;
}

// Calls body(dx, dy, row of the tap, first, last): the pixels [first, last) of the chunk have a
// neighbour at (dx, dy) * step inside the image.
template <class Body>
inline void forTaps(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end, int radius,
                    int step, Body body) {
    for (int dy = -radius; dy <= radius; ++dy) {
        int64_t row = int64_t(y) + int64_t(dy) * step;
        if (row < 0 || row >= int64_t(pass.height))
            continue;
        for (int dx = -radius; dx <= radius; ++dx) {
            int64_t shift = int64_t(dx) * step;
            int64_t first = std::max<int64_t>(begin, -shift);
            int64_t last = std::min<int64_t>(end, int64_t(pass.width) - shift);
            if (first < last)
                body(dx, dy, size_t(row) * pass.stride, uint32_t(first), uint32_t(last));
        }
    }
}

struct GuideRows {
    const float* rows[kMaxGuides];
    GuideRows(const Pass& pass, size_t offset) {
        for (int g = 0; g < kMaxGuides; ++g)
            rows[g] = g < pass.guideCount ? pass.guides[g] + offset : nullptr;
    }
};

inline float brightness(float r, float g, float b) {
    return 0.25f * r + 0.5f * g + 0.25f * b;
}

// A pixel may be as bright as its surroundings' mean and this many standard deviations more, both
// without the brightest pixel there: fireflies seldom come alone.
constexpr float kFireflyDeviations = 5.0f;
// With fewer like neighbours (together) than this there is little to judge a pixel by: it may be
// that many times brighter.
constexpr float kEnoughLikeness = 4.0f, kSlack = 10.0f;
constexpr float kLeastLikeness = 1e-3f; // so that something is left where no neighbour is alike
constexpr float kSmall = 1e-6f;

template <int kGuides>
void repairChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float weights[kChunk], sums[5][kChunk], top[kChunk], topWeight[kChunk];
    std::fill_n(weights, kChunk, 0.0f);
    std::fill_n(top, kChunk, 0.0f);
    std::fill_n(topWeight, kChunk, 0.0f);
    for (auto& sum : sums)
        std::fill_n(sum, kChunk, 0.0f);
    size_t here = y * pass.stride;
    GuideRows center(pass, here);
    forTaps(pass, y, begin, end, kRepairRadius, 1,
            [&](int dx, int dy, size_t row, uint32_t first, uint32_t last) {
                if (dx == 0 && dy == 0)
                    return;
                GuideRows tap(pass, row);
                const float* r = pass.from.color[0] + row;
                const float* g = pass.from.color[1] + row;
                const float* b = pass.from.color[2] + row;
                const float* valid = pass.valid + row;
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
        float limit = mean + kFireflyDeviations * std::sqrt(spread > 0.0f ? spread : 0.0f);
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

template <int kGuides>
void residualChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float weights[kChunk], squares[kChunk], sums[3][kChunk];
    std::fill_n(weights, kChunk, 0.0f);
    std::fill_n(squares, kChunk, 0.0f);
    for (auto& sum : sums)
        std::fill_n(sum, kChunk, 0.0f);
    size_t here = y * pass.stride;
    GuideRows center(pass, here);
    forTaps(pass, y, begin, end, kResidualRadius, 1,
            [&](int dx, int, size_t row, uint32_t first, uint32_t last) {
                GuideRows tap(pass, row);
                const float* r = pass.from.color[0] + row;
                const float* g = pass.from.color[1] + row;
                const float* b = pass.from.color[2] + row;
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
        float inverse = 1.0f / weights[i]; // the pixel itself weighs 1
        float sum = 0.0f;
        for (int c = 0; c < 3; ++c) {
            float mean = sums[c][i] * inverse;
            float rest = pass.from.color[c][here + x] - mean;
            sum += rest * rest;
            pass.pilot.color[c][here + x] = mean;
        }
        pass.pilot.variance[here + x] = squares[i] * inverse * inverse;
        // Of independent noise of variance v the difference to a mean that contains the pixel
        // keeps v * (1 - 2 w0 / W + sum w^2 / W^2), with w0 = 1.
        float kept = 1.0f - 2.0f * inverse + squares[i] * inverse * inverse;
        pass.to.variance[here + x] = kept > 0.1f ? sum / kept : sum;
    }
}

template <int kGuides>
void spreadChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float weights[kChunk], sums[kChunk];
    std::fill_n(weights, kChunk, 0.0f);
    std::fill_n(sums, kChunk, 0.0f);
    size_t here = y * pass.stride;
    GuideRows center(pass, here);
    forTaps(pass, y, begin, end, kSpreadRadius, 1,
            [&](int dx, int dy, size_t row, uint32_t first, uint32_t last) {
                if ((dx + dy) % 2 != 0) // every other pixel tells nearly as much
                    return;
                GuideRows tap(pass, row);
                const float* variance = pass.from.variance + row;
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

#include "denoise/rows_detail.h"

namespace sunstone::denoise {
namespace {

constexpr float kSpline[3] = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f};
constexpr float kLeastVariance = 1e-9f;

template <int kGuides, bool kAlpha>
void smoothChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    float weights[kChunk], sums[5][kChunk];
    std::fill_n(weights, kChunk, 0.0f);
    for (auto& sum : sums)
        std::fill_n(sum, kChunk, 0.0f);
    size_t here = y * pass.stride;
    GuideRows center(pass, here);
    const float* r0 = pass.pilot.color[0] + here;
    const float* g0 = pass.pilot.color[1] + here;
    const float* b0 = pass.pilot.color[2] + here;
    const float* v0 = pass.pilot.variance + here;
    forTaps(pass, y, begin, end, 2, pass.step,
            [&](int dx, int dy, size_t row, uint32_t first, uint32_t last) {
                GuideRows tap(pass, row);
                const float* r = pass.from.color[0] + row;
                const float* g = pass.from.color[1] + row;
                const float* b = pass.from.color[2] + row;
                const float* v = pass.from.variance + row;
                const float* pr = pass.pilot.color[0] + row;
                const float* pg = pass.pilot.color[1] + row;
                const float* pb = pass.pilot.color[2] + row;
                const float* pv = pass.pilot.variance + row;
                const float* alpha = kAlpha ? pass.from.alpha + row : nullptr;
                float spline = kSpline[std::abs(dx)] * kSpline[std::abs(dy)];
                int shift = dx * pass.step;
                for (uint32_t x = first; x < last; ++x) {
                    uint32_t q = uint32_t(int(x) + shift), i = x - begin;
                    float dr = pr[q] - r0[x], dg = pg[q] - g0[x], db = pb[q] - b0[x];
                    float noise = v0[x] + pv[q];
                    float beyond = dr * dr + dg * dg + db * db - noise;
                    beyond = beyond > 0.0f ? beyond : 0.0f;
                    float distance = beyond / (pass.colorTolerance * noise + kLeastVariance) +
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

template <class Chunk>
void forChunks(const Pass& pass, Chunk chunk, uint32_t size = kChunk) {
    for (uint32_t begin = 0; begin < pass.width; begin += size)
        chunk(begin, std::min(pass.width, begin + size));
}

// Picks the variant for a pass's number of guides.
template <class Call>
void withGuides(const Pass& pass, Call call) {
    switch (pass.guideCount) {
    case 2:
        return call.template operator()<2>();
    case 3:
        return call.template operator()<3>();
    case 5:
        return call.template operator()<5>();
    case 6:
        return call.template operator()<6>();
    default:
        return call.template operator()<0>();
    }
}

void repairRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        forChunks(pass, [&](uint32_t a, uint32_t b) { repairChunk<kGuides>(pass, y, a, b); });
    });
}
void residualRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        forChunks(pass, [&](uint32_t a, uint32_t b) { residualChunk<kGuides>(pass, y, a, b); });
    });
}
void spreadRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        forChunks(pass, [&](uint32_t a, uint32_t b) { spreadChunk<kGuides>(pass, y, a, b); });
    });
}
void detailRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        if constexpr (kGuides != 0)
            forChunks(
                pass, [&](uint32_t a, uint32_t b) { detailChunk<kGuides>(pass, y, a, b); },
                kDetailChunk);
    });
}
void smoothRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        forChunks(pass, [&](uint32_t a, uint32_t b) {
            if (pass.hasAlpha)
                smoothChunk<kGuides, true>(pass, y, a, b);
            else
                smoothChunk<kGuides, false>(pass, y, a, b);
        });
    });
}

constexpr RowKernels kKernels = {repairRow, residualRow, spreadRow, detailRow, smoothRow};

} // namespace
} // namespace sunstone::denoise
