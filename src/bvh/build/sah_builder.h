// SPDX-License-Identifier: Apache-2.0
// The quality builder: top down, with the binned surface-area heuristic. Compiled once per
// instruction set.
//
// A wide node starts as one range of references; the child with the largest area is split in two
// until there are eight children or only leaves. A split sorts centroids into bins along all three
// axes at once, sweeps the bins, and takes the plane with the least area * blocks. A block of up to
// four triangles has a constant cost. Ranges above kParallelCount are binned and partitioned by all
// threads; below, children are built as independent tasks. All decisions depend on counts and
// coordinates only, and unions of boxes are exact, so that the tree does not depend on the number
// of threads.
//
// Below kSahDepth levels (pathological input) ranges are halved by count, which bounds the depth.
#pragma once

#include "bvh/build/tree.h"
#include "bvh/parallel.h"
#include "bvh/simd.h"

namespace sunstone::bvh::SUNSTONE_ISA {

constexpr uint32_t kMaxBins = 32;
constexpr uint32_t kParallelCount = 1u << 16;
constexpr uint32_t kPartitionBlock = 1u << 14;
constexpr uint32_t kTaskCount = 2048;
constexpr unsigned kSahDepth = 32;

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

// upper - lower
SUNSTONE_INLINE F4 extent(Bounds b) {
    const F4 sum = highHalf(b.v) + lowHalf(b.v);
    return splat(0.0f, (F4*)nullptr) - sum;
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
    bool splittable[3];

    SUNSTONE_INLINE_MEMBER Binning(const Range& range) {
        const uint32_t wanted = 6 + range.count() / 16;
        count = wanted < kMaxBins ? wanted : kMaxBins;
        alignas(16) float size[4], factor[4] = {};
        store(size, extent(range.centroids));
        for (int i = 0; i < 3; ++i) {
            // Slightly less than count / size, so that the largest centroid falls into the last
            // bin.
            factor[i] = float(count) * 0.99999f / size[i];
            splittable[i] = size[i] > 0 && factor[i] > 0 && factor[i] < 0x1p100f;
            if (!splittable[i])
                factor[i] = 0;
        }
        origin = lowHalf(range.centroids.v);
        scale = load(factor, (F4*)nullptr);
    }
    SUNSTONE_INLINE_MEMBER __m128i bins(F4 c) const {
        return _mm_cvttps_epi32(((c - origin) * scale).v);
    }
};

// Boxes and counts by bin and axis; lane 3 of the counts is undefined.
struct alignas(64) Bins {
    Bounds box[kMaxBins][3];
    alignas(16) uint32_t count[kMaxBins][4];

    SUNSTONE_INLINE_MEMBER void clear(uint32_t bins) {
        for (uint32_t i = 0; i < bins; ++i) {
            box[i][0] = box[i][1] = box[i][2] = emptyBounds();
            _mm_store_si128(reinterpret_cast<__m128i*>(count[i]), _mm_setzero_si128());
        }
    }
    SUNSTONE_INLINE_MEMBER void add(const Binning& binning, const PrimitiveRef* refs, size_t n) {
        for (size_t i = 0; i < n; ++i) {
            const Bounds b = boundsOf(refs[i]);
            const __m128i at = binning.bins(centroid(b));
            const uint64_t xy = uint64_t(_mm_cvtsi128_si64(at));
            const uint32_t x = uint32_t(xy), y = uint32_t(xy >> 32);
            const uint32_t z = uint32_t(_mm_cvtsi128_si32(_mm_unpackhi_epi64(at, at)));
            box[x][0] = unite(box[x][0], b);
            box[y][1] = unite(box[y][1], b);
            box[z][2] = unite(box[z][2], b);
            ++count[x][0];
            ++count[y][1];
            ++count[z][2];
        }
    }
    SUNSTONE_INLINE_MEMBER void merge(const Bins& other, uint32_t bins) {
        for (uint32_t i = 0; i < bins; ++i)
            for (int a = 0; a < 3; ++a) {
                box[i][a] = unite(box[i][a], other.box[i][a]);
                count[i][a] += other.count[i][a];
            }
    }
};

struct Split {
    int axis = -1;                 // -1: halve by position
    uint32_t bin = 0;              // first bin of the right side
    float cost = __builtin_inff(); // sum of area * blocks of both sides
    Bounds left, right;            // boxes of the sides
};

// State of a sweep over the bins, for the three axes side by side.
struct Sweep {
    Bounds box[3] = {emptyBounds(), emptyBounds(), emptyBounds()};
    __m128i count = _mm_setzero_si128();

    SUNSTONE_INLINE_MEMBER void add(const Bins& bins, uint32_t i) {
        for (int a = 0; a < 3; ++a)
            box[a] = unite(box[a], bins.box[i][a]);
        count =
            _mm_add_epi32(count, _mm_load_si128(reinterpret_cast<const __m128i*>(bins.count[i])));
    }
    // area * blocks; infinite if there are fewer references than a leaf needs.
    SUNSTONE_INLINE_MEMBER __m128 cost(const LeafRules& rules) const {
        __m128 x = extent(box[0]).v, y = extent(box[1]).v, z = extent(box[2]).v;
        __m128 unused = _mm_setzero_ps();
        _MM_TRANSPOSE4_PS(x, y, z, unused);
        const __m128 area =
            _mm_add_ps(_mm_add_ps(_mm_mul_ps(x, y), _mm_mul_ps(y, z)), _mm_mul_ps(z, x));
        const __m128i blocks =
            rules.maxCount > 1 ? _mm_srli_epi32(_mm_add_epi32(count, _mm_set1_epi32(3)), 2) : count;
        const __m128 few =
            _mm_castsi128_ps(_mm_cmplt_epi32(count, _mm_set1_epi32(int(rules.minCount))));
        const __m128 cost = _mm_mul_ps(area, _mm_cvtepi32_ps(blocks));
        return _mm_or_ps(_mm_andnot_ps(few, cost), _mm_and_ps(few, _mm_set1_ps(__builtin_inff())));
    }
};

SUNSTONE_INLINE Split bestSplit(const Bins& bins, const Binning& binning, const LeafRules& rules) {
    __m128 rightCost[kMaxBins];
    Sweep right;
    for (uint32_t i = binning.count - 1; i > 0; --i) {
        right.add(bins, i);
        rightCost[i] = right.cost(rules);
    }
    Sweep left;
    __m128 best = _mm_set1_ps(__builtin_inff());
    __m128i bestBin = _mm_setzero_si128();
    for (uint32_t i = 1; i < binning.count; ++i) {
        left.add(bins, i - 1);
        const __m128 cost = _mm_add_ps(left.cost(rules), rightCost[i]);
        const __m128i better = _mm_castps_si128(_mm_cmplt_ps(cost, best));
        best = _mm_min_ps(cost, best); // best where cost is NaN
        bestBin = _mm_or_si128(_mm_and_si128(better, _mm_set1_epi32(int(i))),
                               _mm_andnot_si128(better, bestBin));
    }
    alignas(16) float costs[4];
    alignas(16) uint32_t positions[4];
    _mm_store_ps(costs, best);
    _mm_store_si128(reinterpret_cast<__m128i*>(positions), bestBin);
    Split split;
    for (int axis = 0; axis < 3; ++axis)
        if (binning.splittable[axis] && costs[axis] < split.cost) {
            split.axis = axis;
            split.bin = positions[axis];
            split.cost = costs[axis];
        }
    split.left = split.right = emptyBounds();
    if (split.axis >= 0)
        for (uint32_t i = 0; i < binning.count; ++i) {
            Bounds& side = i < split.bin ? split.left : split.right;
            side = unite(side, bins.box[i][split.axis]);
        }
    return split;
}

class SahBuilder {
public:
    SahBuilder(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
               const LeafRules& rules, Tree& tree)
        : references_(references), scratch_(scratch), count_(count), rules_(rules), tree_(tree) {}

    void run() {
        Range all = summarize(0, count_, false);
        all.leaf = count_ <= rules_.maxCount && (count_ < 2 * rules_.minCount || !wantsSplit(all));
        if (all.leaf) {
            setChild(tree_.root, all);
        } else {
            tree_.root.count = 0;
            tree_.root.first = buildNode(all, 0);
        }
        tree_.references = references_;
    }

private:
    PrimitiveRef* refs(bool inScratch) const { return inScratch ? scratch_ : references_; }

    // Boxes of a range.
    Range summarize(uint32_t begin, uint32_t end, bool inScratch) {
        Range range{emptyBounds(), emptyBounds(), begin, end, inScratch, false, 0};
        const uint32_t n = end - begin, numBlocks = (n + kParallelCount - 1) / kParallelCount;
        if (numBlocks <= 1) {
            unitePart(range, begin, end);
        } else {
            Range* parts = new Range[numBlocks];
            auto body = [&](size_t b, size_t e, size_t block) {
                parts[block] = range;
                unitePart(parts[block], uint32_t(begin + b), uint32_t(begin + e));
            };
            parallelBlocks(n, kParallelCount, body);
            for (uint32_t i = 0; i < numBlocks; ++i) {
                range.box = unite(range.box, parts[i].box);
                range.centroids = unite(range.centroids, parts[i].centroids);
            }
            delete[] parts;
        }
        range.area = areaOf(range.box);
        return range;
    }
    void unitePart(Range& range, uint32_t begin, uint32_t end) const {
        const PrimitiveRef* r = refs(range.inScratch);
        Bounds box = range.box, centroids = range.centroids;
        for (uint32_t i = begin; i < end; ++i) {
            const Bounds b = boundsOf(r[i]);
            box = unite(box, b);
            centroids = unite(centroids, pointBounds(centroid(b)));
        }
        range.box = box;
        range.centroids = centroids;
    }

    Split findSplit(const Range& range, const Binning& binning) {
        Bins bins;
        bins.clear(binning.count);
        const PrimitiveRef* r = refs(range.inScratch) + range.begin;
        const uint32_t n = range.count();
        if (n < kParallelCount) {
            bins.add(binning, r, n);
        } else {
            // Few large parts, because merging bins also costs time.
            const uint32_t part = n / 64 > kPartitionBlock ? n / 64 : kPartitionBlock;
            const uint32_t numParts = (n + part - 1) / part;
            Bins* parts = new Bins[numParts];
            auto body = [&](size_t b, size_t e, size_t block) {
                parts[block].clear(binning.count);
                parts[block].add(binning, r + b, e - b);
            };
            parallelBlocks(n, part, body);
            for (uint32_t i = 0; i < numParts; ++i)
                bins.merge(parts[i], binning.count);
            delete[] parts;
        }
        return bestSplit(bins, binning, rules_);
    }

    bool wantsSplit(const Range& range) {
        return splitPays(range, findSplit(range, Binning(range)));
    }
    // Whether splitting a range that could be a leaf costs less than the leaf.
    bool splitPays(const Range& range, const Split& split) const {
        const float leaf = rules_.cost(range.count()) * range.area;
        return split.axis >= 0 && kSplitCost * range.area + split.cost * rules_.cost4 < leaf;
    }

    // Halves a range by position.
    void halve(const Range& range, Range& left, Range& right) {
        const uint32_t middle = range.begin + range.count() / 2;
        left = summarize(range.begin, middle, range.inScratch);
        right = summarize(middle, range.end, range.inScratch);
    }

    // Splits a range, or marks it as a leaf and returns false.
    bool split(Range& range, unsigned depth, Range& left, Range& right) {
        const bool mayBeLeaf = range.count() <= rules_.maxCount;
        if (range.count() < 2 * rules_.minCount) {
            range.leaf = true;
            return false;
        }
        Split split;
        const Binning binning(range);
        if (depth < kSahDepth)
            split = findSplit(range, binning);
        if (mayBeLeaf && !splitPays(range, split)) {
            range.leaf = true;
            return false;
        }
        if (split.axis < 0)
            halve(range, left, right);
        else if (range.count() < kParallelCount)
            partition(range, binning, split, left, right);
        else
            partitionInParallel(range, binning, split, left, right);
        left.area = areaOf(left.box);
        right.area = areaOf(right.box);
        left.leaf = left.count() < 2 * rules_.minCount && left.count() <= rules_.maxCount;
        right.leaf = right.count() < 2 * rules_.minCount && right.count() <= rules_.maxCount;
        return true;
    }

    // The side of a reference, by the arithmetic of Binning::bins.
    struct Chooser {
        float origin, scale;
        int32_t bin;
        int axis;
        SUNSTONE_INLINE_MEMBER Chooser(const Binning& binning, const Split& split)
            : bin(int32_t(split.bin)), axis(split.axis) {
            alignas(16) float o[4], s[4];
            store(o, binning.origin);
            store(s, binning.scale);
            origin = o[axis];
            scale = s[axis];
        }
        SUNSTONE_INLINE_MEMBER bool left(const PrimitiveRef& r) const {
            return int32_t(((r.lower[axis] - r.negUpper[axis]) - origin) * scale) < bin;
        }
    };

    // Bounds of the centroids on both sides, without an unpredictable branch.
    struct Sides {
        F4 lower[2] = {splat(__builtin_inff(), (F4*)nullptr),
                       splat(__builtin_inff(), (F4*)nullptr)};
        F4 upper[2] = {splat(-__builtin_inff(), (F4*)nullptr),
                       splat(-__builtin_inff(), (F4*)nullptr)};
        SUNSTONE_INLINE_MEMBER void add(bool isLeft, F4 c) {
            const __m128 left = _mm_castsi128_ps(_mm_set1_epi32(-int(isLeft)));
            const __m128 inf = _mm_set1_ps(__builtin_inff());
            const __m128 mine = _mm_and_ps(left, c.v), other = _mm_andnot_ps(left, c.v);
            const __m128 padLeft = _mm_andnot_ps(left, inf), padRight = _mm_and_ps(left, inf);
            const __m128 minus = _mm_set1_ps(-0.0f);
            lower[0] = min({_mm_or_ps(mine, padLeft)}, lower[0]);
            lower[1] = min({_mm_or_ps(other, padRight)}, lower[1]);
            upper[0] =
                max({_mm_or_ps(mine, _mm_or_ps(padLeft, _mm_andnot_ps(left, minus)))}, upper[0]);
            upper[1] =
                max({_mm_or_ps(other, _mm_or_ps(padRight, _mm_and_ps(left, minus)))}, upper[1]);
        }
        SUNSTONE_INLINE_MEMBER void add(const Sides& s) {
            for (int i = 0; i < 2; ++i) {
                lower[i] = min(s.lower[i], lower[i]);
                upper[i] = max(s.upper[i], upper[i]);
            }
        }
        SUNSTONE_INLINE_MEMBER Bounds centroids(int side) const {
            return {fromHalves(lower[side], splat(0.0f, (F4*)nullptr) - upper[side])};
        }
    };

    // Keeps the order: left references move up, right ones go through the other array.
    void partition(const Range& range, const Binning& binning, const Split& split, Range& left,
                   Range& right) {
        PrimitiveRef* const r = refs(range.inScratch);
        PrimitiveRef* const spare = refs(!range.inScratch) + range.begin;
        const Chooser chooser(binning, split);
        Sides sides;
        uint32_t toLeft = range.begin, toRight = 0;
        for (uint32_t i = range.begin; i < range.end; ++i) {
            const bool isLeft = chooser.left(r[i]);
            const F8 whole = boundsOf(r[i]).v;
            sides.add(isLeft, centroid({whole}));
            store(r[toLeft].lower, whole);
            store(spare[toRight].lower, whole);
            toLeft += isLeft;
            toRight += !isLeft;
        }
        for (uint32_t i = 0; i < toRight; ++i)
            r[toLeft + i] = spare[i];
        left = {split.left, sides.centroids(0), range.begin, toLeft, range.inScratch, false, 0};
        right = {split.right, sides.centroids(1), toLeft, range.end, range.inScratch, false, 0};
    }

    // Moves the references into the other array, order kept.
    void partitionInParallel(const Range& range, const Binning& binning, const Split& split,
                             Range& left, Range& right) {
        const PrimitiveRef* from = refs(range.inScratch) + range.begin;
        PrimitiveRef* to = refs(!range.inScratch) + range.begin;
        const Chooser chooser(binning, split);
        const uint32_t n = range.count(), numBlocks = (n + kPartitionBlock - 1) / kPartitionBlock;
        struct Part {
            Sides sides;
            uint32_t numLeft = 0, leftStart = 0;
        };
        Part* parts = new Part[numBlocks];
        auto countBody = [&](size_t b, size_t e, size_t block) {
            Part part;
            for (size_t i = b; i < e; ++i) {
                const bool isLeft = chooser.left(from[i]);
                part.sides.add(isLeft, centroid(boundsOf(from[i])));
                part.numLeft += isLeft;
            }
            parts[block] = part;
        };
        parallelBlocks(n, kPartitionBlock, countBody);
        Sides sides;
        uint32_t numLeft = 0;
        for (uint32_t i = 0; i < numBlocks; ++i) {
            parts[i].leftStart = numLeft;
            numLeft += parts[i].numLeft;
            sides.add(parts[i].sides);
        }
        auto moveBody = [&](size_t b, size_t e, size_t block) {
            uint32_t toLeft = parts[block].leftStart;
            uint32_t toRight = numLeft + uint32_t(b) - toLeft;
            for (size_t i = b; i < e; ++i) {
                const bool isLeft = chooser.left(from[i]);
                to[isLeft ? toLeft : toRight] = from[i];
                toLeft += isLeft;
                toRight += !isLeft;
            }
        };
        parallelBlocks(n, kPartitionBlock, moveBody);
        delete[] parts;
        const uint32_t middle = range.begin + numLeft;
        left = {split.left, sides.centroids(0), range.begin, middle, !range.inScratch, false, 0};
        right = {split.right, sides.centroids(1), middle, range.end, !range.inScratch, false, 0};
    }

    // The range to split next: the largest, or -1.
    static int pick(const Range* ranges, unsigned count, bool byCount) {
        int best = -1;
        float bestSize = -1;
        for (unsigned i = 0; i < count; ++i) {
            const float size = byCount ? float(ranges[i].count()) : ranges[i].area;
            // The comparison also accepts infinite or NaN areas, which belong to boxes too large
            // for floats.
            if (!ranges[i].leaf && !(size <= bestSize)) {
                best = int(i);
                bestSize = size;
            }
        }
        return best;
    }

    uint32_t buildNode(const Range& all, unsigned depth) {
        Range ranges[8] = {all};
        unsigned count = 1;
        for (int i; count < 8 && (i = pick(ranges, count, depth >= kSahDepth)) >= 0;) {
            Range left, right;
            if (!split(ranges[i], depth, left, right))
                continue;
            ranges[i] = left;
            ranges[count++] = right;
        }
        // Undecided ranges may become leaves.
        for (unsigned i = 0; i < count; ++i)
            if (!ranges[i].leaf && ranges[i].count() <= rules_.maxCount)
                ranges[i].leaf = depth + 1 >= kSahDepth || !wantsSplit(ranges[i]);
        const uint32_t index = tree_.numNodes.fetch_add(1, std::memory_order_relaxed);
        TreeNode& node = tree_.nodes[index];
        node.numChildren = count;
        const auto child = [&](unsigned i) {
            setChild(node.children[i], ranges[i]);
            if (!ranges[i].leaf) {
                node.children[i].count = 0;
                node.children[i].first = buildNode(ranges[i], depth + 1);
            }
        };
        if (all.count() < kTaskCount) {
            for (unsigned i = 0; i < count; ++i)
                child(i);
        } else {
            auto body = [&](size_t i, size_t, size_t) { child(unsigned(i)); };
            parallelBlocks(count, 1, body);
        }
        setBytes(node);
        return index;
    }

    void setBytes(TreeNode& node) const {
        uint64_t leaves = 0, inner = 0;
        for (unsigned i = 0; i < node.numChildren; ++i) {
            const TreeChild& c = node.children[i];
            if (c.count)
                leaves += rules_.bytes(c.count);
            else
                inner += tree_.nodes[c.first].bytes;
        }
        node.bytes = rules_.nodeBytes + (leaves + 63) / 64 * 64 + inner;
    }

    // Makes a leaf; its references move to the first array, which emission reads.
    void setChild(TreeChild& child, const Range& range) {
        alignas(32) float b[8];
        store(b, range.box.v);
        for (int i = 0; i < 3; ++i) {
            child.lower[i] = b[i];
            child.upper[i] = -b[4 + i];
        }
        child.first = range.begin;
        child.count = range.count();
        if (range.leaf && range.inScratch)
            for (uint32_t i = range.begin; i < range.end; ++i)
                references_[i] = scratch_[i];
    }

    // Splitting a would-be leaf costs about this part of a node visit.
    static constexpr float kSplitCost = 0.3f;

    PrimitiveRef* references_;
    PrimitiveRef* scratch_;
    uint32_t count_;
    const LeafRules rules_;
    Tree& tree_;
};

} // namespace sunstone::bvh::SUNSTONE_ISA
