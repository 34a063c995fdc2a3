// SPDX-License-Identifier: Apache-2.0
// Rules of the CPU's and GPU's builders: which long thin triangles are split before a tree is built
// (presplit.h), and the maximal number of splits.
#pragma once

#include "base/inline.h"

#include <cstdint>

namespace sunstone::bvh {

// Triangles are split only if the area of their box is at least this multiple of their need.
// Triangles of ordinary meshes in any orientation have up to 4, and splitting them costs more than
// it gains.
constexpr double kWorthwhile = 10;
constexpr uint32_t kMostSplits = 31; // of one triangle

// Half the area of a triangle's box, and the half area that a box needs for a triangle of that
// size.
struct SplitMeasure {
    double box, need;
};

SUNSTONE_INLINE SplitMeasure splitMeasure(const float v[9]) {
    double size[3], a[3], b[3];
    for (int i = 0; i < 3; ++i) {
        const float low = v[i] < v[3 + i] ? v[i] : v[3 + i];
        const float high = v[i] < v[3 + i] ? v[3 + i] : v[i];
        size[i] = double(high < v[6 + i] ? v[6 + i] : high) - (v[6 + i] < low ? v[6 + i] : low);
        a[i] = double(v[3 + i]) - v[i];
        b[i] = double(v[6 + i]) - v[i];
    }
    double need = 0;
    for (int i = 0; i < 3; ++i) {
        const int j = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
        need += 0.5 * __builtin_fabs(a[j] * b[k] - a[k] * b[j]);
    }
    return {size[0] * size[1] + size[1] * size[2] + size[2] * size[0], need};
}

SUNSTONE_INLINE bool isWorthSplitting(SplitMeasure m) {
    return m.box > kWorthwhile * m.need && m.box < 1e300;
}

// The most splits of a triangle that is worth splitting.
SUNSTONE_INLINE uint32_t splitLimit(SplitMeasure m) {
    const double share = m.need > 1e-3 * m.box ? m.box / m.need : 1e3;
    return share < kMostSplits ? uint32_t(share) : kMostSplits;
}

} // namespace sunstone::bvh
