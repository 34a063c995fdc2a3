// SPDX-License-Identifier: Apache-2.0
// Bins of the quality builder: references sorted by centroid into up to 32 bins along each axis,
// and the best plane between them. Compiled once per instruction set.
#pragma once

#include "bvh/build/tree.h"
#include "bvh/simd.h"

namespace sunstone::bvh::SUNSTONE_ISA {

constexpr uint32_t kMaxBins = 32;
constexpr uint32_t kGroup = 16; // references whose places are computed together

// Lower corner in words 0-2, negated upper in 4-6; words 3 and 7 are undefined.
struct Bounds {
    F8 v;
};
SUNSTONE_INLINE Bounds emptyBounds() {
    return {splat(__builtin_inff(), (F8*)nullptr)};
}
SUNSTONE_INLINE Bounds unite(Bounds a, Bounds b) {
    return {min(a.v, b.v)};
}
SUNSTONE_INLINE Bounds boundsOf(const PrimitiveRef& ref) {
    return {load(ref.lower, (F8*)nullptr)};
}

SUNSTONE_INLINE F4 highHalf(F8 a) {
#if defined(__AVX2__)
    return {_mm256_extractf128_ps(a.v, 1)};
#else
    return {a.hi};
#endif
}
SUNSTONE_INLINE F8 fromHalves(F4 lo, F4 hi) {
#if defined(__AVX2__)
    return {_mm256_set_m128(hi.v, lo.v)};
#else
    return {lo.v, hi.v};
#endif
}

// lower - upper
SUNSTONE_INLINE F4 negExtent(Bounds b) {
    return highHalf(b.v) + lowHalf(b.v);
}
SUNSTONE_INLINE F4 extent(Bounds b) {
    return splat(0.0f, (F4*)nullptr) - negExtent(b);
}
SUNSTONE_INLINE float areaOf(Bounds b) {
    alignas(16) float d[4];
    store(d, extent(b));
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}
// Twice the centroid, in words 0-2.
SUNSTONE_INLINE F4 centroid(Bounds b) {
    return lowHalf(b.v) - highHalf(b.v);
}
SUNSTONE_INLINE Bounds pointBounds(F4 c) {
    return {fromHalves(c, splat(0.0f, (F4*)nullptr) - c)};
}

struct Range {
    Bounds box, centroids;
    uint32_t begin, end;
    bool inScratch; // which of the two arrays holds the references
    bool leaf;
    float area;

    uint32_t count() const { return end - begin; }
};

// The mapping of centroids to bins.
struct Binning {
    F4 origin, scale;
    uint32_t count;
    uint32_t splittable; // bits of axes

    SUNSTONE_INLINE_MEMBER Binning(const Range& range) {
        const uint32_t wanted = 6 + range.count() / 16;
        count = wanted < kMaxBins ? wanted : kMaxBins;
        // Slightly less than count / size, so that the largest centroid falls into the last bin.
        const __m128 size = extent(range.centroids).v;
        const __m128 factor = _mm_div_ps(_mm_set1_ps(float(count) * 0.99999f), size);
        const __m128 usable = _mm_and_ps(_mm_cmpgt_ps(size, _mm_setzero_ps()),
                                         _mm_and_ps(_mm_cmpgt_ps(factor, _mm_setzero_ps()),
                                                    _mm_cmplt_ps(factor, _mm_set1_ps(0x1p100f))));
        splittable = uint32_t(_mm_movemask_ps(usable));
        scale = {_mm_and_ps(usable, factor)};
        origin = lowHalf(range.centroids.v);
    }
    SUNSTONE_INLINE_MEMBER __m128i bins(F4 c) const {
        return _mm_cvttps_epi32(((c - origin) * scale).v);
    }
};

// A bin is the box of its references, with their number as a float in word 7 and 0 in word 3.
SUNSTONE_INLINE __m128 withLastWord(__m128 a, __m128 last) {
#if defined(__SSE4_1__)
    return _mm_blend_ps(a, last, 8);
#else
    const __m128 mask = _mm_castsi128_ps(_mm_setr_epi32(0, 0, 0, -1));
    return _mm_or_ps(_mm_andnot_ps(mask, a), _mm_and_ps(mask, last));
#endif
}
SUNSTONE_INLINE Bounds makeBin(Bounds box, float count) {
    return {fromHalves({withLastWord(lowHalf(box.v).v, _mm_setzero_ps())},
                       {withLastWord(highHalf(box.v).v, _mm_set1_ps(count))})};
}
SUNSTONE_INLINE Bounds uniteBins(Bounds a, Bounds b) {
#if defined(__AVX2__)
    return {{_mm256_blend_ps(min(a.v, b.v).v, (a.v + b.v).v, 0x80)}};
#else
    const F8 box = min(a.v, b.v);
    return {{box.lo, withLastWord(box.hi, _mm_add_ps(a.v.hi, b.v.hi))}};
#endif
}

// Bins of the three axes.
struct alignas(64) Bins {
    Bounds bin[kMaxBins][3];

    SUNSTONE_INLINE_MEMBER void clear(uint32_t bins) {
        const Bounds empty = makeBin(emptyBounds(), 0);
        for (uint32_t i = 0; i < bins; ++i)
            bin[i][0] = bin[i][1] = bin[i][2] = empty;
    }
    // References 1, 3, 5... go into `odd`, which may be this. A processor delays loads until it
    // knows the addresses of earlier stores, and until an earlier store to the same address is
    // done. So the places of a group are computed before its first store, and two sets of bins
    // serve many references, because neighbours often share a bin.
    SUNSTONE_INLINE_MEMBER void add(const Binning& binning, const PrimitiveRef* refs, size_t n,
                                    Bins& odd) {
        alignas(16) uint32_t at[kGroup][4];
        for (size_t first = 0; first < n; first += kGroup) {
            const size_t group = n - first < kGroup ? n - first : kGroup;
            for (size_t i = 0; i < group; ++i)
                _mm_store_si128(reinterpret_cast<__m128i*>(at[i]),
                                binning.bins(centroid(boundsOf(refs[first + i]))));
            size_t i = 0;
            for (; i + 1 < group; i += 2) {
                add(at[i], refs[first + i]);
                odd.add(at[i + 1], refs[first + i + 1]);
            }
            if (i < group)
                add(at[i], refs[first + i]);
        }
    }
    SUNSTONE_INLINE_MEMBER void add(const uint32_t at[3], const PrimitiveRef& ref) {
        const Bounds b = makeBin(boundsOf(ref), 1);
        for (int a = 0; a < 3; ++a)
            bin[at[a]][a] = uniteBins(bin[at[a]][a], b);
    }
    SUNSTONE_INLINE_MEMBER void merge(const Bins& other, uint32_t bins) {
        for (uint32_t i = 0; i < bins; ++i)
            for (int a = 0; a < 3; ++a)
                bin[i][a] = uniteBins(bin[i][a], other.bin[i][a]);
    }
};

struct Split {
    int axis = -1;                 // -1: halve by position
    uint32_t bin = 0;              // first bin of the right side
    float cost = __builtin_inff(); // sum of area * blocks of both sides
    Bounds left, right;            // boxes of the sides
};

// Bins from one end to a boundary, for the three axes.
struct Sweep {
    Bounds bin[3];

    SUNSTONE_INLINE_MEMBER Sweep() { bin[0] = bin[1] = bin[2] = makeBin(emptyBounds(), 0); }
    SUNSTONE_INLINE_MEMBER void add(const Bins& bins, uint32_t i) {
        for (int a = 0; a < 3; ++a)
            bin[a] = uniteBins(bin[a], bins.bin[i][a]);
    }
};

// lower - upper, and the count in words 3 and 7, of two bins.
SUNSTONE_INLINE F8 negExtents(Bounds a, Bounds b) {
#if defined(__AVX2__)
    return F8{_mm256_permute2f128_ps(a.v.v, b.v.v, 0x20)} +
           F8{_mm256_permute2f128_ps(a.v.v, b.v.v, 0x31)};
#else
    return F8{a.v.lo, b.v.lo} + F8{a.v.hi, b.v.hi};
#endif
}

// Rows of four words become columns, in both halves.
SUNSTONE_INLINE void transpose(F8 rows[4]) {
#if defined(__AVX2__)
    const __m256 a = _mm256_unpacklo_ps(rows[0].v, rows[1].v);
    const __m256 b = _mm256_unpackhi_ps(rows[0].v, rows[1].v);
    const __m256 c = _mm256_unpacklo_ps(rows[2].v, rows[3].v);
    const __m256 d = _mm256_unpackhi_ps(rows[2].v, rows[3].v);
    rows[0] = {_mm256_shuffle_ps(a, c, 0x44)};
    rows[1] = {_mm256_shuffle_ps(a, c, 0xEE)};
    rows[2] = {_mm256_shuffle_ps(b, d, 0x44)};
    rows[3] = {_mm256_shuffle_ps(b, d, 0xEE)};
#else
    _MM_TRANSPOSE4_PS(rows[0].lo, rows[1].lo, rows[2].lo, rows[3].lo);
    _MM_TRANSPOSE4_PS(rows[0].hi, rows[1].hi, rows[2].hi, rows[3].hi);
#endif
}

// count blocks of four, rounded up
SUNSTONE_INLINE F8 blocksOf(F8 count) {
    const F8 quarters = (count + splat(3.0f, (F8*)nullptr)) * splat(0.25f, (F8*)nullptr);
#if defined(__AVX2__)
    return {_mm256_cvtepi32_ps(_mm256_cvttps_epi32(quarters.v))};
#else
    return {_mm_cvtepi32_ps(_mm_cvttps_epi32(quarters.lo)),
            _mm_cvtepi32_ps(_mm_cvttps_epi32(quarters.hi))};
#endif
}

// cost, or infinity where count < least.
SUNSTONE_INLINE F8 infiniteBelow(F8 count, float least, F8 cost) {
#if defined(__AVX2__)
    return {_mm256_blendv_ps(cost.v, _mm256_set1_ps(__builtin_inff()),
                             _mm256_cmp_ps(count.v, _mm256_set1_ps(least), _CMP_LT_OQ))};
#else
    const auto half = [&](__m128 n, __m128 c) {
        const __m128 few = _mm_cmplt_ps(n, _mm_set1_ps(least));
        return _mm_or_ps(_mm_andnot_ps(few, c), _mm_and_ps(few, _mm_set1_ps(__builtin_inff())));
    };
    return {half(count.lo, cost.lo), half(count.hi, cost.hi)};
#endif
}

// area * blocks of the left side by axis in words 0-2, of the right side in words 4-6; infinite if
// there are fewer references than a leaf needs.
SUNSTONE_INLINE F8 costs(const Sweep& left, const Sweep& right, const LeafRules& rules) {
    F8 rows[4];
    for (int a = 0; a < 3; ++a)
        rows[a] = negExtents(left.bin[a], right.bin[a]);
    rows[3] = splat(0.0f, (F8*)nullptr);
    transpose(rows);
    const F8 area = rows[0] * rows[1] + rows[1] * rows[2] + rows[2] * rows[0];
    const F8 blocks = rules.maxCount > 1 ? blocksOf(rows[3]) : rows[3];
    return infiniteBelow(rows[3], float(rules.minCount), area * blocks);
}

SUNSTONE_INLINE Split bestSplit(const Bins& bins, const Binning& binning, const LeafRules& rules) {
    // Left sides of boundary i beside right sides of boundary count - i.
    F8 sides[kMaxBins];
    Sweep left, right;
    for (uint32_t i = 1; i < binning.count; ++i) {
        left.add(bins, i - 1);
        right.add(bins, binning.count - i);
        sides[i] = costs(left, right, rules);
    }
    __m128 best = _mm_set1_ps(__builtin_inff());
    __m128i bestBin = _mm_setzero_si128();
    for (uint32_t i = 1; i < binning.count; ++i) {
        const __m128 cost = _mm_add_ps(lowHalf(sides[i]).v, highHalf(sides[binning.count - i]).v);
        const __m128i better = _mm_castps_si128(_mm_cmplt_ps(cost, best));
        best = _mm_min_ps(cost, best); // best where cost is NaN
        bestBin = _mm_or_si128(_mm_and_si128(better, _mm_set1_epi32(int(i))),
                               _mm_andnot_si128(better, bestBin));
    }
    alignas(16) float bestCosts[4];
    alignas(16) uint32_t positions[4];
    _mm_store_ps(bestCosts, best);
    _mm_store_si128(reinterpret_cast<__m128i*>(positions), bestBin);
    Split split;
    for (int axis = 0; axis < 3; ++axis)
        if ((binning.splittable >> axis & 1) && bestCosts[axis] < split.cost) {
            split.axis = axis;
            split.bin = positions[axis];
            split.cost = bestCosts[axis];
        }
    Bounds leftBox = emptyBounds(), rightBox = emptyBounds();
    if (split.axis >= 0) {
        for (uint32_t i = 0; i < split.bin; ++i)
            leftBox = unite(leftBox, bins.bin[i][split.axis]);
        for (uint32_t i = split.bin; i < binning.count; ++i)
            rightBox = unite(rightBox, bins.bin[i][split.axis]);
    }
    split.left = leftBox;
    split.right = rightBox;
    return split;
}

} // namespace sunstone::bvh::SUNSTONE_ISA
