// SPDX-License-Identifier: Apache-2.0
#include "bvh/build/emit.h"

#include "bvh/parallel.h"

#include <algorithm>

namespace sunstone::bvh {
namespace {

constexpr uint64_t kTaskBytes = 1u << 18;

class Emitter {
public:
    Emitter(const Tree& tree, const LeafRules& rules, const LeafWriter& writer, uint8_t* block)
        : tree_(tree), rules_(rules), writer_(writer), block_(block) {}

    NodeRef emitNode(uint32_t index, uint64_t offset) const {
        const TreeNode& from = tree_.nodes[index];
        Node& node = *reinterpret_cast<Node*>(block_ + offset);
        for (int p = 0; p < 6; ++p)
            std::fill(node.planes[p], node.planes[p] + 8,
                      p % 2 ? -__builtin_inff() : __builtin_inff());
        std::fill(node.children, node.children + 8, kNoNode);
        node.numChildren = from.numChildren;
        std::fill(std::begin(node.pad), std::end(node.pad), 0u);
        unsigned order[8];
        sortByArea(from, order);
        prefetchLeaves(from);
        uint64_t leafAt = offset + rules_.nodeBytes, innerAt[8];
        for (unsigned i = 0; i < from.numChildren; ++i) {
            const TreeChild& c = from.children[order[i]];
            for (int a = 0; a < 3; ++a) {
                node.planes[2 * a][i] = c.lower[a];
                node.planes[2 * a + 1][i] = c.upper[a];
            }
            if (c.count) {
                node.children[i] =
                    writer_.write(block_, leafAt, tree_.references + c.first, c.count);
                leafAt += rules_.bytes(c.count);
            }
        }
        if (const uint64_t padded = (leafAt + 63) / 64 * 64; padded != leafAt) {
            std::fill(block_ + leafAt, block_ + padded, uint8_t(0));
            leafAt = padded;
        }
        for (unsigned i = 0; i < from.numChildren; ++i) {
            innerAt[i] = leafAt;
            if (const TreeChild& c = from.children[order[i]]; c.count == 0)
                leafAt += tree_.nodes[c.first].bytes;
        }
        auto body = [&](size_t begin, size_t end, size_t) {
            for (size_t i = begin; i < end; ++i)
                if (const TreeChild& c = from.children[order[i]]; c.count == 0)
                    node.children[i] = emitNode(c.first, innerAt[i]);
        };
        if (from.bytes < kTaskBytes)
            body(0, from.numChildren, 0);
        else
            parallelBlocks(from.numChildren, 1, body);
        return makeRef(offset, kInner);
    }

private:
    void prefetchLeaves(const TreeNode& node) const {
        for (int round = 0; round < LeafWriter::kPrefetchRounds; ++round)
            for (unsigned i = 0; i < node.numChildren; ++i)
                if (const TreeChild& c = node.children[i]; c.count)
                    writer_.prefetch(tree_.references + c.first, c.count, round);
    }

    // Large children come first, because rays that end at any hit visit children in this order.
    static void sortByArea(const TreeNode& node, unsigned order[8]) {
        float area[8];
        for (unsigned i = 0; i < node.numChildren; ++i) {
            const TreeChild& c = node.children[i];
            const float x = c.upper[0] - c.lower[0], y = c.upper[1] - c.lower[1],
                        z = c.upper[2] - c.lower[2];
            area[i] = x * y + y * z + z * x;
            unsigned j = i;
            for (; j > 0 && area[order[j - 1]] < area[i]; --j)
                order[j] = order[j - 1];
            order[j] = i;
        }
    }

    const Tree& tree_;
    const LeafRules& rules_;
    const LeafWriter& writer_;
    uint8_t* block_;
};

} // namespace

void emitTree(const Tree& tree, const LeafRules& rules, const LeafWriter& writer, uint8_t* block,
              uint64_t offset) {
    BlockHeader& header = *reinterpret_cast<BlockHeader*>(block);
    header.numNodes = tree.numNodes;
    if (tree.root.count) {
        header.root =
            writer.write(block, offset, tree.references + tree.root.first, tree.root.count);
        header.usedSize = offset + (rules.bytes(tree.root.count) + 63) / 64 * 64;
        return;
    }
    header.root = Emitter(tree, rules, writer, block).emitNode(tree.root.first, offset);
    header.usedSize = offset + tree.nodes[tree.root.first].bytes;
}

} // namespace sunstone::bvh
