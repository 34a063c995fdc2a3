// SPDX-License-Identifier: Apache-2.0
// The row kernel that finds the part of the colours that guides explain; part of rows_body.h, whose
// helpers it uses. For each pixel a weighted regression of the colours around it on the guides
// (first-order regression after Moon et al. 2014 and Bitterli et al. 2016, but once, over small
// windows):
//
//   colour(q) ~ a + b * (guides(q) - guides(pixel))
//
// According to b the pixel differs from its surroundings (the shading of a bump, the share of two
// surfaces in a pixel at a silhouette). This difference is subtracted before the passes, which
// would smooth it, and added back after them. It is scaled down the more, the less of the
// surroundings' variance it explains beyond a regression on noise.
#include "denoise/rows/rows.h"

namespace sunstone::denoise {
namespace {

// Surroundings. Guides may differ more than for smoothing, because the regression needs
// differences. Pixels several times brighter or darker belong to other structures (a highlight, a
// lamp, a shadow).
constexpr float kDetailGuidePart = 0.2f;
constexpr float kDetailLightPart = 1.5f;
constexpr int kDetailDisc = 18; // squared radius of the surroundings
// Ridge, in squared units of the guides' tolerance: noise in guides must not count as a cause.
constexpr float kRidge = 0.1f;
constexpr float kSmallLight = 1e-6f;
// The third coordinate of a normal is redundant after the first two.
constexpr int kMaxCauses = 5;
constexpr int causesOf(int guides) {
    return guides < kMaxCauses ? guides : kMaxCauses;
}

template <int kCauses, uint32_t kSize>
struct Moments {
    static constexpr int kPairs = kCauses * (kCauses + 1) / 2;
    float weight[kSize], squaredWeight[kSize], squaredColor[kSize];
    float guide[kCauses][kSize], color[3][kSize];
    float pair[kPairs][kSize], mixed[kCauses][3][kSize];
};

// The planes read of the pixels themselves.
template <int kGuides>
struct Own {
    OwnGuides<kGuides> guides;
    OwnRow color[3], pilot[3];

    Own(const Pass& pass, Place here, uint32_t begin) : guides(pass, here, begin) {
        for (int k = 0; k < 3; ++k) {
            color[k] = OwnRow(pass.from.color[k], here, begin);
            pilot[k] = OwnRow(pass.pilot.color[k], here, begin);
        }
    }
};

template <int kGuides, uint32_t kSize>
inline void addTap(const Pass& pass, const Own<kGuides>& own, Place row, int dx, uint32_t begin,
                   uint32_t first, uint32_t last, Moments<causesOf(kGuides), kSize>& sums) {
    const GuideRows<kGuides> tap(pass, row);
    Row color[3], pilot[3];
    for (int k = 0; k < 3; ++k) {
        color[k] = Row(pass.from.color[k], row);
        pilot[k] = Row(pass.pilot.color[k], row);
    }
    for (uint32_t x = first; x < last; ++x) {
        uint32_t q = uint32_t(int(x) + dx), i = x - begin;
        float d[kGuides], c[3], distance = 0.0f;
        for (int g = 0; g < kGuides; ++g) {
            d[g] = tap.rows[g][q] - own.guides.rows[g][x];
            distance += d[g] * d[g];
        }
        float light = brightness(own.pilot[0][x], own.pilot[1][x], own.pilot[2][x]);
        float other = brightness(pilot[0][q], pilot[1][q], pilot[2][q]);
        float product = light * other, step = light - other;
        product = product > 0.0f ? product : 0.0f;
        float w = falloff(distance * kDetailGuidePart +
                          kDetailLightPart * step * step / (product + kSmallLight));
        sums.weight[i] += w;
        sums.squaredWeight[i] += w * w;
        float square = 0.0f;
        for (int k = 0; k < 3; ++k) { // against the pixel's own: fewer digits are lost
            c[k] = color[k][q] - own.color[k][x];
            square += c[k] * c[k];
            sums.color[k][i] += w * c[k];
        }
        sums.squaredColor[i] += w * square;
        int pair = 0;
        for (int g = 0; g < causesOf(kGuides); ++g) {
            float wd = w * d[g];
            sums.guide[g][i] += wd;
            for (int h = 0; h <= g; ++h)
                sums.pair[pair++][i] += wd * d[h];
            for (int k = 0; k < 3; ++k)
                sums.mixed[g][k][i] += wd * c[k];
        }
    }
}

// The guides of pixel i of the chunk, relative to the mean of its surroundings.
template <int kCauses, uint32_t kSize>
inline void explain(const Moments<kCauses, kSize>& sums, uint32_t i, float (&detail)[3]) {
    float inverse = 1.0f / sums.weight[i]; // the pixel itself has weight 1
    float guide[kCauses], color[3], matrix[kCauses][kCauses], pivot[kCauses];
    float total = sums.squaredColor[i] * inverse, explained = 0.0f;
    for (int g = 0; g < kCauses; ++g)
        guide[g] = sums.guide[g][i] * inverse;
    for (int k = 0; k < 3; ++k) {
        color[k] = sums.color[k][i] * inverse;
        total -= color[k] * color[k];
    }
    // Covariance of the guides = L D L^T, below the diagonal in place.
    int pair = 0;
    for (int g = 0; g < kCauses; ++g)
        for (int h = 0; h <= g; ++h) {
            float value = sums.pair[pair++][i] * inverse - guide[g] * guide[h];
            for (int m = 0; m < h; ++m)
                value -= matrix[g][m] * matrix[h][m] * pivot[m];
            if (g == h) {
                value += kRidge;
                pivot[g] = value > 0.5f * kRidge ? value : 0.5f * kRidge; // rounding
            } else {
                matrix[g][h] = value / pivot[h];
            }
        }
    for (int k = 0; k < 3; ++k) {
        float slope[kCauses], joint[kCauses];
        for (int g = 0; g < kCauses; ++g) {
            joint[g] = sums.mixed[g][k][i] * inverse - guide[g] * color[k];
            slope[g] = joint[g];
            for (int m = 0; m < g; ++m)
                slope[g] -= matrix[g][m] * slope[m];
        }
        for (int g = kCauses - 1; g >= 0; --g) {
            slope[g] = slope[g] / pivot[g];
            for (int m = g + 1; m < kCauses; ++m)
                slope[g] -= matrix[m][g] * slope[m];
        }
        detail[k] = 0.0f;
        for (int g = 0; g < kCauses; ++g) {
            explained += slope[g] * joint[g];
            detail[k] -= slope[g] * guide[g];
        }
    }
    float effective = sums.weight[i] * sums.weight[i] / sums.squaredWeight[i] - float(kCauses + 1);
    effective = effective > 1.0f ? effective : 1.0f;
    float rest = total > explained ? total - explained : 0.0f;
    float chance = float(kCauses) * rest / effective; // explained in noise alone
    float trust = explained > chance ? 1.0f - chance / explained : 0.0f;
    for (int k = 0; k < 3; ++k)
        detail[k] *= trust;
}

template <int kGuides, uint32_t kSize>
inline void detailChunk(const Pass& pass, uint32_t y, uint32_t begin, uint32_t end) {
    Moments<causesOf(kGuides), kSize> sums = {};
    const Place here = Place(y) * Place(pass.stride);
    const Own<kGuides> own(pass, here, begin);
    forTaps<kDetailRadius, kSize>(
        pass, y, begin, end, 1, [&](int dx, int dy, Place row, uint32_t first, uint32_t last) {
            // Every other pixel of a disc: the result is nearly as good.
            if ((dx + dy) % 2 != 0 || dx * dx + dy * dy > kDetailDisc)
                return;
            addTap<kGuides, kSize>(pass, own, row, dx, begin, first, last, sums);
        });
    for (uint32_t x = begin; x < end; ++x) {
        float detail[3];
        explain(sums, x - begin, detail);
        for (int k = 0; k < 3; ++k) {
            pass.detail[k][here + x] = detail[k];
            pass.to.color[k][here + x] = pass.from.color[k][here + x] - detail[k];
        }
        pass.to.variance[here + x] = pass.from.variance[here + x];
    }
}

} // namespace
} // namespace sunstone::denoise
