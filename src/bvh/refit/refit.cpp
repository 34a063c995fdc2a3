// SPDX-License-Identifier: Apache-2.0
// In memory, each node is followed by its leaves (emit.h), so a subtree is scanned without
// following references: first the leaves, with prefetches of the vertices of later leaves, then the
// nodes backwards, children before parents.
#include "bvh/refit/refit.h"

#include "bvh/parallel.h"
#include "bvh/refit/refit_leaves.h"

namespace sunstone::bvh {
namespace {

// Subtrees of fewer bytes are scanned by one thread, within its cache.
constexpr uint64_t kTaskBytes = 1u << 17;
constexpr uint32_t kTaskNodes = kTaskBytes / sizeof(Node);
constexpr uint32_t kTaskLeaves = 8 * kTaskNodes;
// Number of leaves ahead for which indices and vertices are prefetched.
constexpr uint32_t kIndicesAhead = 16, kVerticesAhead = 6;
constexpr uint64_t kNodesAhead = 2048; // bytes

class Refit {
public:
    Refit(uint8_t* block, const Sources& sources)
        : block_(block), header_(*reinterpret_cast<BlockHeader*>(block)), leaves_(block, sources) {}

    void run() {
        Extent all;
        const NodeRef root = header_.wholeRoot;
        if (root != kNoNode)
            all = isInner(root) ? refitSubtree(offsetOf(root), header_.usedSize)
                                : leaves_.refit(root);
        header_.root = all.active ? root : kNoNode;
        header_.numActive = all.active;
        alignas(16) float lower[4], upper[4];
        _mm_store_ps(lower, all.exact.lower);
        _mm_store_ps(upper, all.exact.upper);
        std::copy(lower, lower + 3, header_.lower);
        std::copy(upper, upper + 3, header_.upper);
    }

private:
    // The nodes of a subtree in the order of memory, and their leaves in the same order.
    struct Scan {
        uint32_t numNodes = 0, numLeaves = 0;
        uint32_t nodes[kTaskNodes + 1]; // offset / kRefUnit
        NodeRef leaves[kTaskLeaves + kIndicesAhead];
    };

    static bool isInner(NodeRef ref) { return (ref & kNodeTagMask) == kInner; }
    Node& nodeAt(uint64_t offset) const { return *reinterpret_cast<Node*>(block_ + offset); }
    static uint32_t countOf(const Node& node) { return std::min(node.numChildren, 8u); }

    static void setBox(Node& node, uint32_t child, const LaneBox& box) {
        alignas(16) float lower[4], upper[4];
        _mm_store_ps(lower, box.lower);
        _mm_store_ps(upper, box.upper);
        for (int a = 0; a < 3; ++a) {
            node.planes[2 * a][child] = lower[a];
            node.planes[2 * a + 1][child] = upper[a];
        }
    }

    // Splits a large subtree into the subtrees of its inner children, which are contiguous.
    Extent refitSubtree(uint64_t offset, uint64_t end) const {
        if (end - offset < kTaskBytes)
            return scanSubtree(offset, end);
        Node& node = nodeAt(offset);
        const uint32_t count = countOf(node);
        uint64_t ends[8] = {};
        for (uint32_t i = count; i-- > 0;) {
            ends[i] = end;
            if (isInner(node.children[i]))
                end = offsetOf(node.children[i]);
        }
        Extent children[8];
        auto body = [&](size_t begin, size_t stop, size_t) {
            for (size_t i = begin; i < stop; ++i)
                children[i] = isInner(node.children[i])
                                  ? refitSubtree(offsetOf(node.children[i]), ends[i])
                                  : leaves_.refit(node.children[i]);
        };
        parallelBlocks(count, 1, body);
        Extent all;
        for (uint32_t i = 0; i < count; ++i) {
            setBox(node, i, children[i].padded);
            all.add(children[i]);
        }
        return all;
    }

    Extent scanSubtree(uint64_t offset, uint64_t end) const {
        Scan scan;
        collect(scan, offset, end);
        Extent all = refitLeaves(scan);
        all.padded = refitNodes(scan);
        return all;
    }

    void collect(Scan& scan, uint64_t offset, uint64_t end) const {
        while (offset < end && scan.numNodes < kTaskNodes) {
            const Node& node = nodeAt(offset);
            scan.nodes[scan.numNodes++] = uint32_t(offset / kRefUnit);
            uint64_t next = offset + sizeof(Node);
            for (uint32_t i = 0; i < countOf(node); ++i)
                if (const NodeRef ref = node.children[i]; !isInner(ref)) {
                    scan.leaves[scan.numLeaves++] = ref;
                    next += leaves_.bytes(ref);
                }
            next = (next + 63) / 64 * 64;
            for (uint64_t line = offset; line < next; line += 64)
                __builtin_prefetch(block_ + line + kNodesAhead);
            offset = next;
        }
    }

    // Sets the leaves and their boxes in the nodes.
    Extent refitLeaves(Scan& scan) const {
        const uint32_t last = scan.numLeaves;
        for (uint32_t i = 0; i < std::min(kIndicesAhead, last); ++i)
            leaves_.prefetchIndices(scan.leaves[i]);
        for (uint32_t i = 0; i < std::min(kVerticesAhead, last); ++i)
            leaves_.prefetchVertices(scan.leaves[i]);
        Extent all;
        uint32_t at = 0;
        for (uint32_t n = 0; n < scan.numNodes; ++n) {
            Node& node = nodeAt(uint64_t(scan.nodes[n]) * kRefUnit);
            for (uint32_t i = 0; i < countOf(node); ++i) {
                if (isInner(node.children[i]))
                    continue;
                if (at + kIndicesAhead < last)
                    leaves_.prefetchIndices(scan.leaves[at + kIndicesAhead]);
                if (at + kVerticesAhead < last)
                    leaves_.prefetchVertices(scan.leaves[at + kVerticesAhead]);
                const Extent leaf = leaves_.refit(scan.leaves[at++]);
                setBox(node, i, leaf.padded);
                all.add(leaf);
            }
        }
        return all;
    }

    // Sets the boxes above inner nodes. In backward order, the inner children of a node are the
    // last finished nodes, the first child on top.
    LaneBox refitNodes(const Scan& scan) const {
        LaneBox done[kTaskNodes + 1];
        uint32_t numDone = 0;
        for (uint32_t n = scan.numNodes; n-- > 0;) {
            Node& node = nodeAt(uint64_t(scan.nodes[n]) * kRefUnit);
            for (uint32_t i = 0; i < countOf(node); ++i)
                if (isInner(node.children[i]) && numDone > 0)
                    setBox(node, i, done[--numDone]);
            done[numDone++] = boxOf(node);
        }
        return done[0];
    }

    // Unused children have empty boxes.
    static LaneBox boxOf(const Node& node) {
        const auto planes = [&](int p, int half) { return _mm_load_ps(node.planes[p] + 4 * half); };
        const auto low = [&](int a) { return _mm_min_ps(planes(2 * a, 0), planes(2 * a, 1)); };
        const auto high = [&](int a) {
            return _mm_max_ps(planes(2 * a + 1, 0), planes(2 * a + 1, 1));
        };
        return {leastOfLanes(low(0), low(1), low(2)), mostOfLanes(high(0), high(1), high(2))};
    }

    uint8_t* block_;
    BlockHeader& header_;
    const LeafRefit leaves_;
};

} // namespace

Sources::Sources(const BuildInputs& inputs) : instances(inputs.instances) {
    uint32_t firstSbt = 0;
    const auto addSbt = [&](const SbtInput& input) {
        sbt.emplace_back(input, firstSbt);
        firstSbt += input.numSbtRecords;
    };
    for (const TriangleInput& input : inputs.triangles) {
        triangles.emplace_back(input);
        addSbt(input.sbt);
    }
    for (const CustomInput& input : inputs.customs) {
        customs.emplace_back(input);
        addSbt(input.sbt);
    }
    if (instances)
        lookAtChildren(*instances);
}

void refit(uint8_t* block, const Sources& sources) {
    Refit(block, sources).run();
}

} // namespace sunstone::bvh
