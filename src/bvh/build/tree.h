// SPDX-License-Identifier: Apache-2.0
// Input and output of tree builders. A builder orders references to primitives and makes a tree of
// eight-wide nodes over ranges of them; emit.h writes nodes and leaves into the block.
//
//   references -> sah_builder.h (quality) or morton_builder.cpp (speed) -> TreeNode[] -> emit.h
#pragma once

#include "bvh/layout.h"

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace sunstone::bvh {

// A primitive's box and number. The upper corner is negated, so that one minimum over all eight
// words unites boxes.
struct alignas(32) PrimitiveRef {
    float lower[3];
    uint32_t primitive; // position among the primitives of its input
    float negUpper[3];
    uint32_t input;
};
static_assert(sizeof(PrimitiveRef) == 32);

// Leaves of triangles hold 2 to 8; leaves of other kinds exactly one.
struct LeafRules {
    uint32_t minCount;
    uint32_t maxCount;
    // Cost of a visit to a leaf with up to 4 or 8 primitives, in visits to a node.
    float cost4 = 1.0f;
    float cost8 = 1.35f;

    // Bytes of a node in the block: more than a Node with motion.
    uint32_t nodeBytes = sizeof(Node);

    float cost(uint32_t count) const { return count <= 4 ? cost4 : cost8; }
    // Bytes in the block.
    uint32_t bytes4, bytes8;
    uint32_t bytes(uint32_t count) const { return count <= 4 ? bytes4 : bytes8; }
};

struct TreeChild {
    float lower[3];
    uint32_t first; // index of a TreeNode, or of the first reference of a leaf
    float upper[3];
    uint32_t count; // references in the leaf; 0: a node
};

struct alignas(16) TreeNode {
    TreeChild children[8];
    uint32_t numChildren;
    uint32_t pad;
    uint64_t bytes; // of the subtree in the block: this node, its leaves, its inner children
};

struct Tree {
    TreeNode* nodes = nullptr; // node 0 is the root, unless the root is a leaf
    uint32_t capacity = 0;
    std::atomic<uint32_t> numNodes{0};
    const PrimitiveRef* references = nullptr; // in leaf order
    TreeChild root;                           // count != 0: the whole tree is one leaf
};

// Upper bounds of the nodes of a tree over n references, and of its bytes in the block.
uint32_t maxTreeNodes(uint64_t n, const LeafRules& rules);
uint64_t maxTreeBytes(uint64_t n, const LeafRules& rules);

// The builders. `references` holds `count` entries (count > 0), `scratch` has room for as many
// (twice as many for Morton); tree.nodes has room for maxTreeNodes. The result is in `tree`; its
// references are in one of the two arrays.
void buildSahTree(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
                  const LeafRules& rules, Tree& tree);
void buildMortonTree(PrimitiveRef* references, PrimitiveRef* scratch, uint32_t count,
                     const LeafRules& rules, Tree& tree);

} // namespace sunstone::bvh
