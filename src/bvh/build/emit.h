// SPDX-License-Identifier: Apache-2.0
// Writes a tree into a block: nodes depth first, each node followed by its leaves.
#pragma once

#include "bvh/build/tree.h"

namespace sunstone::bvh {

// Writes leaves; one implementation for each kind of primitive.
class LeafWriter {
public:
    virtual ~LeafWriter() = default;
    // A leaf of `count` references at `offset` of the block; returns its NodeRef.
    virtual NodeRef write(uint8_t* block, uint64_t offset, const PrimitiveRef* references,
                          uint32_t count) const = 0;
    // Fetches the input of references that are written soon. Triangles of a leaf are far apart in
    // memory; in two rounds all their indices and then all their vertices arrive together.
    virtual void prefetch(const PrimitiveRef*, uint32_t /*count*/, int /*round*/) const {}
    static constexpr int kPrefetchRounds = 2;
};

// Writes all nodes and leaves from `offset` on; sets root, usedSize and numNodes of the header.
void emitTree(const Tree& tree, const LeafRules& rules, const LeafWriter& writer, uint8_t* block,
              uint64_t offset);

} // namespace sunstone::bvh
