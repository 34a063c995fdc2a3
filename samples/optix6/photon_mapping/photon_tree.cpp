// SPDX-License-Identifier: Apache-2.0
#include "photon_tree.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace {

float component(const optix::float3& v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

// The number of nodes, of `count`, in the left subtree of a complete tree whose last level is
// filled from the left.
size_t leftCount(size_t count) {
    size_t full = 1; // nodes of the levels above the last
    while (2 * full + 1 <= count)
        full = 2 * full + 1;
    const size_t last = count - full, half = (full + 1) / 2;
    return (full - 1) / 2 + std::min(last, half);
}

int widestAxis(const Photon* begin, const Photon* end) {
    int widest = 0;
    float width = -1.0f;
    for (int axis = 0; axis < 3; ++axis) {
        float low = std::numeric_limits<float>::max(), high = -low;
        for (const Photon* each = begin; each != end; ++each) {
            low = std::min(low, component(each->place, axis));
            high = std::max(high, component(each->place, axis));
        }
        if (high - low > width) {
            width = high - low;
            widest = axis;
        }
    }
    return widest;
}

void build(Photon* begin, Photon* end, std::vector<Photon>& tree, size_t node) {
    const size_t count = size_t(end - begin);
    if (count == 0)
        return;
    const int axis = widestAxis(begin, end);
    Photon* middle = begin + leftCount(count);
    std::nth_element(begin, middle, end, [axis](const Photon& a, const Photon& b) {
        return component(a.place, axis) < component(b.place, axis);
    });
    tree[node] = *middle;
    tree[node].axis = count == 1 ? int(kLeafAxis) : axis;
    build(begin, middle, tree, 2 * node + 1);
    build(middle + 1, end, tree, 2 * node + 2);
}

} // namespace

std::vector<Photon> buildTree(const Photon* photons, size_t count) {
    std::vector<Photon> stored;
    std::copy_if(photons, photons + count, std::back_inserter(stored), [](const Photon& each) {
        return each.normal.x != 0 || each.normal.y != 0 || each.normal.z != 0;
    });
    std::vector<Photon> tree(stored.size());
    build(stored.data(), stored.data() + stored.size(), tree, 0);
    return tree;
}
