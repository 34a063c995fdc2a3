// SPDX-License-Identifier: Apache-2.0
// The fast builder: references sorted along a space-filling curve, ranges split where the highest
// bit of their Morton codes changes (Lauterbach et al. 2009). Nodes are opened by count. Boxes are
// computed bottom up.
#include "bvh/build/tree.h"
#include "bvh/parallel.h"

#include <algorithm>
#include <cstring>
#include <memory>

namespace sunstone::bvh {
namespace {

constexpr unsigned kBitsPerAxis = 14, kDigitBits = 11, kDigits = 4;
constexpr uint32_t kSortBlock = 1u << 17, kRadix = 1u << kDigitBits;
constexpr uint32_t kTaskCount = 4096;
static_assert(kDigitBits * kDigits >= 3 * kBitsPerAxis);
constexpr unsigned kMortonDepth = 32; // deeper ranges are halved, see sah_builder.h

struct Key {
    uint64_t code;
    uint32_t reference;
    uint32_t pad;
};
static_assert(sizeof(Key) == 16);

struct Bounds {
    float v[6] = {__builtin_inff(), __builtin_inff(), __builtin_inff(),
                  __builtin_inff(), __builtin_inff(), __builtin_inff()}; // lower, negated upper
    void add(const float lower[3], const float negUpper[3]) {
        for (int i = 0; i < 3; ++i) {
            v[i] = std::min(v[i], lower[i]);
            v[3 + i] = std::min(v[3 + i], negUpper[i]);
        }
    }
    void add(const Bounds& b) { add(b.v, b.v + 3); }
};

// Spreads the low bits of x so that two zeros follow each.
uint64_t spread(uint64_t x) {
    x = (x | x << 32) & 0x001F00000000FFFFull;
    x = (x | x << 16) & 0x001F0000FF0000FFull;
    x = (x | x << 8) & 0x100F00F00F00F00Full;
    x = (x | x << 4) & 0x10C30C30C30C30C3ull;
    x = (x | x << 2) & 0x1249249249249249ull;
    return x;
}

class MortonBuilder {
public:
    MortonBuilder(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
                  const LeafRules& rules, Tree& tree)
        : references_(references), sorted_(scratch), keys_(reinterpret_cast<Key*>(scratch + count)),
          otherKeys_(keys_ + count), count_(count), rules_(rules), tree_(tree) {}

    void run() {
        makeKeys();
        sortKeys();
        auto gather = [&](size_t b, size_t e, size_t) {
            for (size_t i = b; i < e; ++i)
                sorted_[i] = references_[keys_[i].reference];
        };
        parallelBlocks(count_, kSortBlock, gather);
        tree_.references = sorted_;
        if (isLeaf(0, count_)) {
            makeLeaf(tree_.root, 0, count_);
            return;
        }
        tree_.root.count = 0;
        tree_.root.first = buildNode(0, count_, 0, tree_.root);
    }

private:
    struct Range {
        uint32_t begin, end;
        bool leaf;
    };

    bool isLeaf(uint32_t begin, uint32_t end) const {
        return end - begin <= std::min(4u, rules_.maxCount);
    }

    void makeKeys() {
        const size_t numBlocks = (count_ + kSortBlock - 1) / kSortBlock;
        auto parts = std::make_unique<Bounds[]>(numBlocks);
        auto unite = [&](size_t b, size_t e, size_t block) {
            Bounds box;
            for (size_t i = b; i < e; ++i) {
                float c[3], negated[3];
                centroid(references_[i], c);
                for (int a = 0; a < 3; ++a)
                    negated[a] = -c[a];
                box.add(c, negated);
            }
            parts[block] = box;
        };
        parallelBlocks(count_, kSortBlock, unite);
        Bounds all;
        for (size_t i = 0; i < numBlocks; ++i)
            all.add(parts[i]);
        float scale[3];
        for (int a = 0; a < 3; ++a) {
            const float size = -all.v[3 + a] - all.v[a];
            scale[a] = size > 0 ? float(1u << kBitsPerAxis) * 0.9999f / size : 0;
            if (!(scale[a] < 0x1p100f))
                scale[a] = 0;
        }
        auto fill = [&](size_t b, size_t e, size_t) {
            for (size_t i = b; i < e; ++i) {
                float c[3];
                centroid(references_[i], c);
                uint64_t code = 0;
                for (int a = 0; a < 3; ++a)
                    code |= spread(uint64_t((c[a] - all.v[a]) * scale[a])) << a;
                keys_[i] = {code, uint32_t(i), 0};
            }
        };
        parallelBlocks(count_, kSortBlock, fill);
    }

    static void centroid(const PrimitiveRef& r, float c[3]) {
        for (int a = 0; a < 3; ++a)
            c[a] = r.lower[a] - r.negUpper[a];
    }

    // Least significant digit first, stable; the result is in keys_.
    void sortKeys() {
        const size_t numBlocks = (count_ + kSortBlock - 1) / kSortBlock;
        auto counts = std::make_unique<uint32_t[]>(numBlocks * kRadix);
        for (unsigned digit = 0; digit < kDigits; ++digit) {
            const unsigned shift = digit * kDigitBits;
            auto count = [&](size_t b, size_t e, size_t block) {
                uint32_t* const c = counts.get() + block * kRadix;
                std::memset(c, 0, kRadix * sizeof(uint32_t));
                for (size_t i = b; i < e; ++i)
                    ++c[keys_[i].code >> shift & (kRadix - 1)];
            };
            parallelBlocks(count_, kSortBlock, count);
            uint32_t start = 0;
            for (uint32_t value = 0; value < kRadix; ++value)
                for (size_t block = 0; block < numBlocks; ++block) {
                    uint32_t& c = counts[block * kRadix + value];
                    const uint32_t n = c;
                    c = start;
                    start += n;
                }
            auto move = [&](size_t b, size_t e, size_t block) {
                uint32_t* const c = counts.get() + block * kRadix;
                for (size_t i = b; i < e; ++i)
                    otherKeys_[c[keys_[i].code >> shift & (kRadix - 1)]++] = keys_[i];
            };
            parallelBlocks(count_, kSortBlock, move);
            std::swap(keys_, otherKeys_);
        }
    }

    // First position whose code has the highest differing bit set; the middle if codes are equal.
    uint32_t splitPosition(uint32_t begin, uint32_t end, unsigned depth) const {
        const uint64_t first = keys_[begin].code, last = keys_[end - 1].code;
        uint32_t position = begin + (end - begin) / 2;
        if (first != last && depth < kMortonDepth) {
            const uint64_t bit = 1ull << (63 - __builtin_clzll(first ^ last));
            uint32_t low = begin, high = end - 1; // code[low] has the bit clear, code[high] set
            while (high - low > 1) {
                const uint32_t middle = low + (high - low) / 2;
                (keys_[middle].code & bit ? high : low) = middle;
            }
            position = high;
        }
        return std::clamp(position, begin + rules_.minCount, end - rules_.minCount);
    }

    uint32_t buildNode(uint32_t begin, uint32_t end, unsigned depth, TreeChild& self) {
        Range ranges[8] = {{begin, end, false}};
        unsigned count = 1;
        while (count < 8) {
            int best = -1;
            for (unsigned i = 0; i < count; ++i)
                if (!ranges[i].leaf && (best < 0 || ranges[i].end - ranges[i].begin >
                                                        ranges[best].end - ranges[best].begin))
                    best = int(i);
            if (best < 0)
                break;
            const Range r = ranges[best];
            const uint32_t middle = splitPosition(r.begin, r.end, depth);
            for (unsigned i = count; i > unsigned(best) + 1; --i)
                ranges[i] = ranges[i - 1];
            ranges[best] = {r.begin, middle, isLeaf(r.begin, middle)};
            ranges[best + 1] = {middle, r.end, isLeaf(middle, r.end)};
            ++count;
        }
        const uint32_t index = tree_.numNodes.fetch_add(1, std::memory_order_relaxed);
        TreeNode& node = tree_.nodes[index];
        node.numChildren = count;
        auto body = [&](size_t b, size_t e, size_t) {
            for (size_t i = b; i < e; ++i) {
                TreeChild& c = node.children[i];
                if (ranges[i].leaf) {
                    makeLeaf(c, ranges[i].begin, ranges[i].end);
                } else {
                    c.count = 0;
                    c.first = buildNode(ranges[i].begin, ranges[i].end, depth + 1, c);
                }
            }
        };
        if (end - begin < kTaskCount)
            body(0, count, 0);
        else
            parallelBlocks(count, 1, body);
        finishNode(node, self);
        return index;
    }

    void makeLeaf(TreeChild& c, uint32_t begin, uint32_t end) const {
        Bounds box;
        for (uint32_t i = begin; i < end; ++i)
            box.add(sorted_[i].lower, sorted_[i].negUpper);
        setBox(c, box);
        c.first = begin;
        c.count = end - begin;
    }

    static void setBox(TreeChild& c, const Bounds& box) {
        for (int a = 0; a < 3; ++a) {
            c.lower[a] = box.v[a];
            c.upper[a] = -box.v[3 + a];
        }
    }

    void finishNode(TreeNode& node, TreeChild& self) const {
        Bounds box;
        uint64_t leaves = 0, inner = 0;
        for (unsigned i = 0; i < node.numChildren; ++i) {
            const TreeChild& c = node.children[i];
            const float negUpper[3] = {-c.upper[0], -c.upper[1], -c.upper[2]};
            box.add(c.lower, negUpper);
            (c.count ? leaves : inner) +=
                c.count ? rules_.bytes(c.count) : tree_.nodes[c.first].bytes;
        }
        setBox(self, box);
        node.bytes = rules_.nodeBytes + (leaves + 63) / 64 * 64 + inner;
    }

    PrimitiveRef* references_;
    PrimitiveRef* sorted_;
    Key* keys_;
    Key* otherKeys_;
    uint32_t count_;
    const LeafRules rules_;
    Tree& tree_;
};

} // namespace

void buildMortonTree(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
                     const LeafRules& rules, Tree& tree) {
    MortonBuilder(references, scratch, count, rules, tree).run();
}

} // namespace sunstone::bvh
