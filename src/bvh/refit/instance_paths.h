// SPDX-License-Identifier: Apache-2.0
// Updates of a few instances among many: updates the records of these instances and the boxes on
// their paths to the root. An update of the whole structure (refit.h) takes time for every
// instance.
//
// The block has no references from children to parents, so this class collects the paths once after
// a build, in host memory. They are valid until the block is built again.
#pragma once

#include "bvh/build/build.h"
#include "bvh/layout.h"

#include <span>
#include <vector>

namespace sunstone::bvh {

class InstancePaths {
public:
    InstancePaths() = default;
    // `block` is a structure of instances without motion that was built with allowUpdate. Throws
    // Error(kInvalidValue) for other blocks.
    explicit InstancePaths(const void* block);

    // Updates the `changed` instances of this block from `inputs`, which have as many instances as
    // the build. The header's bounds become those of the padded boxes. Whole updates in between are
    // allowed.
    void refit(void* block, const InstanceInput& inputs, std::span<const uint32_t> changed);

    // The cost of a ray, relative to the tree after its build: the surface of all boxes relative to
    // that of the root.
    double degradation() const;

private:
    static constexpr uint32_t kNoPlace = ~0u;
    Node& nodeOf(uint8_t* block, uint32_t number) const;
    // Sets a box of a node and those above it.
    void setBoxes(uint8_t* block, uint32_t place, const float lower[3], const float upper[3]);

    // A place is the number of a node, times eight, plus the number of a child.
    std::vector<uint32_t> instances_; // place of each instance's box
    std::vector<uint32_t> parents_;   // place of each node's box in its parent
    uint64_t nodesOffset_ = 0;
    double surface_ = 0; // sum over all boxes in nodes
    double rootSurface_ = 0;
    double builtRatio_ = 0;
};

} // namespace sunstone::bvh
