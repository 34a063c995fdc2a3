// SPDX-License-Identifier: Apache-2.0
#include "bvh/refit/instance_paths.h"

#include "base/error.h"
#include "bvh/build/instance_bounds.h"
#include "bvh/input/build_input.h"

#include <algorithm>
#include <limits>

namespace sunstone::bvh {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Corners {
    float lower[3] = {kInfinity, kInfinity, kInfinity};
    float upper[3] = {-kInfinity, -kInfinity, -kInfinity};
};

Corners boxOf(const Node& node, uint32_t child) {
    Corners box;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = node.planes[2 * a][child];
        box.upper[a] = node.planes[2 * a + 1][child];
    }
    return box;
}

// Unused children have empty boxes.
Corners boxOf(const Node& node) {
    Corners box;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = *std::min_element(node.planes[2 * a], node.planes[2 * a] + 8);
        box.upper[a] = *std::max_element(node.planes[2 * a + 1], node.planes[2 * a + 1] + 8);
    }
    return box;
}

bool isEmpty(const Corners& box) {
    return !(box.lower[0] <= box.upper[0]);
}

double surfaceOf(const Corners& box) {
    if (isEmpty(box))
        return 0;
    double edge[3];
    for (int a = 0; a < 3; ++a)
        edge[a] = double(box.upper[a]) - double(box.lower[a]);
    return edge[0] * edge[1] + edge[1] * edge[2] + edge[2] * edge[0];
}

double ratio(double part, double whole) {
    return whole > 0 ? part / whole : 0;
}

} // namespace

InstancePaths::InstancePaths(const void* block) {
    const BlockHeader& header = *headerOf(block);
    if (!isBlock(block) || header.type != BlockType::kInstances ||
        !(header.options & kOptionUpdate))
        fail(Code::kInvalidValue, block, " is no structure of instances that may be updated");
    nodesOffset_ = header.nodesOffset;
    instances_.assign(header.numPrimitives, kNoPlace);
    auto* const bytes = static_cast<uint8_t*>(const_cast<void*>(block));
    const auto numberOf = [&](NodeRef ref) {
        return uint32_t((offsetOf(ref) - nodesOffset_) / sizeof(Node));
    };
    if (header.wholeRoot == kNoNode || (header.wholeRoot & kNodeTagMask) != kInner)
        return;
    parents_.assign((header.usedSize - nodesOffset_) / sizeof(Node), kNoPlace);
    std::vector<uint32_t> queue = {numberOf(header.wholeRoot)};
    rootSurface_ = surfaceOf(boxOf(nodeOf(bytes, queue[0])));
    while (!queue.empty()) {
        const uint32_t number = queue.back();
        queue.pop_back();
        const Node& node = nodeOf(bytes, number);
        for (uint32_t i = 0; i < std::min(node.numChildren, 8u); ++i) {
            const NodeRef child = node.children[i];
            surface_ += surfaceOf(boxOf(node, i));
            if ((child & kNodeTagMask) == kInner) {
                parents_[numberOf(child)] = number * 8 + i;
                queue.push_back(numberOf(child));
            } else {
                instances_[(offsetOf(child) - header.instancesOffset) / sizeof(InstanceRecord)] =
                    number * 8 + i;
            }
        }
    }
    builtRatio_ = ratio(surface_, rootSurface_);
}

Node& InstancePaths::nodeOf(uint8_t* block, uint32_t number) const {
    return *reinterpret_cast<Node*>(block + nodesOffset_ + uint64_t(number) * sizeof(Node));
}

void InstancePaths::setBoxes(uint8_t* block, uint32_t place, const float lower[3],
                             const float upper[3]) {
    Corners box;
    std::copy_n(lower, 3, box.lower);
    std::copy_n(upper, 3, box.upper);
    while (place != kNoPlace) {
        Node& node = nodeOf(block, place / 8);
        const uint32_t child = place % 8;
        const Corners before = boxOf(node, child);
        surface_ += surfaceOf(box) - surfaceOf(before);
        for (int a = 0; a < 3; ++a) {
            node.planes[2 * a][child] = box.lower[a];
            node.planes[2 * a + 1][child] = box.upper[a];
        }
        box = boxOf(node);
        place = parents_[place / 8];
    }
    rootSurface_ = surfaceOf(box);
}

void InstancePaths::refit(void* block, const InstanceInput& inputs,
                          std::span<const uint32_t> changed) {
    auto* const bytes = static_cast<uint8_t*>(block);
    BlockHeader& header = *static_cast<BlockHeader*>(block);
    auto* const records = reinterpret_cast<InstanceRecord*>(bytes + header.instancesOffset);
    const OpenLevels levels = OpenLevels::of(header.options);
    for (const uint32_t index : changed) {
        Corners box;
        const bool active = describeInstance(instanceAt(inputs, index), index, levels,
                                             records[index], box.lower, box.upper);
        if (!active)
            box = {};
        const uint32_t place = instances_[index];
        if (place == kNoPlace) { // the only instance is the root
            std::copy_n(box.lower, 3, header.lower);
            std::copy_n(box.upper, 3, header.upper);
            header.numActive = active;
            continue;
        }
        const bool wasActive = !isEmpty(boxOf(nodeOf(bytes, place / 8), place % 8));
        header.numActive += uint32_t(active) - uint32_t(wasActive);
        if (active)
            padBox(box.lower, box.upper);
        setBoxes(bytes, place, box.lower, box.upper);
    }
    header.root = header.numActive ? header.wholeRoot : kNoNode;
    if (parents_.empty() || changed.empty())
        return;
    const Corners all =
        boxOf(nodeOf(bytes, uint32_t((offsetOf(header.wholeRoot) - nodesOffset_) / sizeof(Node))));
    std::copy_n(all.lower, 3, header.lower);
    std::copy_n(all.upper, 3, header.upper);
}

double InstancePaths::degradation() const {
    return builtRatio_ > 0 && rootSurface_ > 0 ? ratio(surface_, rootSurface_) / builtRatio_ : 1;
}

} // namespace sunstone::bvh
