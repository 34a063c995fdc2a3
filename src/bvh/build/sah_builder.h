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

#include "bvh/build/sah_bins.h"
#include "bvh/parallel.h"

namespace sunstone::bvh::SUNSTONE_ISA {

constexpr uint32_t kParallelCount = 1u << 16;
constexpr uint32_t kPartitionBlock = 1u << 14;
constexpr uint32_t kTwoSetsCount = 512;
constexpr uint32_t kTaskCount = 2048;
constexpr unsigned kSahDepth = 32;

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

    static void addByTwoSets(Bins& bins, const Binning& binning, const PrimitiveRef* refs,
                             size_t n) {
        Bins odd;
        odd.clear(binning.count);
        bins.add(binning, refs, n, odd);
        bins.merge(odd, binning.count);
    }

    Split findSplit(const Range& range, const Binning& binning) {
        Bins bins;
        bins.clear(binning.count);
        const PrimitiveRef* r = refs(range.inScratch) + range.begin;
        const uint32_t n = range.count();
        if (n < kTwoSetsCount) {
            bins.add(binning, r, n, bins);
        } else if (n < kParallelCount) {
            addByTwoSets(bins, binning, r, n);
        } else {
            // Few large parts, because merging bins also costs time.
            const uint32_t part = n / 64 > kPartitionBlock ? n / 64 : kPartitionBlock;
            const uint32_t numParts = (n + part - 1) / part;
            Bins* parts = new Bins[numParts];
            auto body = [&](size_t b, size_t e, size_t block) {
                parts[block].clear(binning.count);
                addByTwoSets(parts[block], binning, r + b, e - b);
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
        // The sides of up to kGroup references, as bits: see Bins::add.
        SUNSTONE_INLINE_MEMBER uint32_t left(const PrimitiveRef* refs, size_t n) const {
            uint32_t bits = 0;
            for (size_t i = 0; i < n; ++i)
                bits |= uint32_t(left(refs[i])) << i;
            return bits;
        }
    };

    // Bounds of the centroids on both sides, without an unpredictable branch: the other side's
    // centroids become NaN, which unite ignores as its first operand.
    struct Sides {
        Bounds left = emptyBounds(), right = emptyBounds();
        SUNSTONE_INLINE_MEMBER void add(bool isLeft, F4 c) {
            const __m128 outside = _mm_castsi128_ps(_mm_set1_epi32(int(isLeft) - 1));
            const __m128 inside = _mm_castsi128_ps(_mm_set1_epi32(-int(isLeft)));
            const F4 minus = splat(0.0f, (F4*)nullptr) - c;
            left =
                unite({fromHalves({_mm_or_ps(c.v, outside)}, {_mm_or_ps(minus.v, outside)})}, left);
            right =
                unite({fromHalves({_mm_or_ps(c.v, inside)}, {_mm_or_ps(minus.v, inside)})}, right);
        }
        SUNSTONE_INLINE_MEMBER void add(const Sides& s) {
            left = unite(s.left, left);
            right = unite(s.right, right);
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
        for (uint32_t first = range.begin; first < range.end; first += kGroup) {
            const uint32_t group = range.end - first < kGroup ? range.end - first : kGroup;
            uint32_t bits = chooser.left(r + first, group);
            for (uint32_t i = first; i < first + group; ++i, bits >>= 1) {
                const uint32_t isLeft = bits & 1;
                const F8 whole = boundsOf(r[i]).v;
                sides.add(isLeft, centroid({whole}));
                store(r[toLeft].lower, whole);
                store(spare[toRight].lower, whole);
                toLeft += isLeft;
                toRight += 1 - isLeft;
            }
        }
        for (uint32_t i = 0; i < toRight; ++i)
            r[toLeft + i] = spare[i];
        left = {split.left, sides.left, range.begin, toLeft, range.inScratch, false, 0};
        right = {split.right, sides.right, toLeft, range.end, range.inScratch, false, 0};
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
            for (size_t first = b; first < e; first += kGroup) {
                const size_t group = e - first < kGroup ? e - first : kGroup;
                uint32_t bits = chooser.left(from + first, group);
                for (size_t i = first; i < first + group; ++i, bits >>= 1) {
                    const uint32_t isLeft = bits & 1;
                    store(to[isLeft ? toLeft : toRight].lower, boundsOf(from[i]).v);
                    toLeft += isLeft;
                    toRight += 1 - isLeft;
                }
            }
        };
        parallelBlocks(n, kPartitionBlock, moveBody);
        delete[] parts;
        const uint32_t middle = range.begin + numLeft;
        left = {split.left, sides.left, range.begin, middle, !range.inScratch, false, 0};
        right = {split.right, sides.right, middle, range.end, !range.inScratch, false, 0};
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
