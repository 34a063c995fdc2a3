// SPDX-License-Identifier: Apache-2.0
#include "bvh/build/instance_bounds.h"

#include "bvh/input/build_input.h"
#include "bvh/motion/instance_poses.h"
#include "math/affine.h"

#include <emmintrin.h>

#include <algorithm>
#include <cmath>

namespace sunstone::bvh {
namespace {

// Transforms boxes; x, y and z of the result are in one vector.
class BoxTurner {
public:
    void setMatrix(const float m[12]) {
        const __m128 sign = _mm_set1_ps(-0.0f);
        for (int c = 0; c < 4; ++c) {
            column_[c] = _mm_setr_ps(m[c], m[4 + c], m[8 + c], 0);
            size_[c] = _mm_andnot_ps(sign, column_[c]);
        }
    }

    // Unites the bounds with the boxes of a node's children. For a child whose box exceeds the
    // bounds so far, uses the boxes of its children in its place.
    void add(const BlockHeader* header, NodeRef ref, unsigned levels) {
        const Node& node = *reinterpret_cast<const Node*>(reinterpret_cast<const uint8_t*>(header) +
                                                          offsetOf(ref));
        for (uint32_t i = 0; i < std::min(node.numChildren, 8u); ++i) {
            if (!(node.planes[0][i] <= node.planes[1][i]))
                continue; // no active primitive is below
            __m128 lower, upper;
            turn(node, i, lower, upper);
            const __m128 inside =
                _mm_and_ps(_mm_cmple_ps(lower_, lower), _mm_cmple_ps(upper, upper_));
            if ((_mm_movemask_ps(inside) & 7) == 7)
                continue;
            if (levels > 1 && (node.children[i] & kNodeTagMask) == kInner) {
                add(header, node.children[i], levels - 1);
            } else {
                lower_ = _mm_min_ps(lower_, lower);
                upper_ = _mm_max_ps(upper_, upper);
            }
        }
    }

    // Empty if a coordinate exceeds the range of boxes.
    math::Box box() const {
        alignas(16) float lower[4], upper[4];
        _mm_store_ps(lower, lower_);
        _mm_store_ps(upper, upper_);
        math::Box box;
        if (_mm_movemask_ps(lost_) & 7)
            return box;
        for (int a = 0; a < 3; ++a) {
            box.lower[a] = lower[a];
            box.upper[a] = upper[a];
        }
        return box;
    }

private:
    void turn(const Node& node, uint32_t i, __m128& lower, __m128& upper) {
        __m128 middle = column_[3], reach = _mm_setzero_ps(), magnitude = size_[3];
        for (int a = 0; a < 3; ++a) {
            const float low = node.planes[2 * a][i], high = node.planes[2 * a + 1][i];
            const float center = 0.5f * low + 0.5f * high, half = 0.5f * high - 0.5f * low;
            middle = _mm_add_ps(middle, _mm_mul_ps(column_[a], _mm_set1_ps(center)));
            reach = _mm_add_ps(reach, _mm_mul_ps(size_[a], _mm_set1_ps(half)));
            magnitude =
                _mm_add_ps(magnitude, _mm_mul_ps(size_[a], _mm_set1_ps(std::fabs(center) + half)));
        }
        // The margin of math::transformBox, and the error of the sums above.
        reach = _mm_add_ps(reach, _mm_mul_ps(magnitude, _mm_set1_ps(0x1.8p-20f)));
        lower = _mm_sub_ps(middle, reach);
        upper = _mm_add_ps(middle, reach);
        const __m128 most = _mm_set1_ps(kMaxCoordinate);
        lost_ = _mm_or_ps(lost_, _mm_cmpnle_ps(magnitude, most)); // NaN too
    }

    __m128 column_[4], size_[4]; // of the transform, and magnitudes
    __m128 lower_ = _mm_set1_ps(__builtin_inff()), upper_ = _mm_set1_ps(-__builtin_inff());
    __m128 lost_ = _mm_setzero_ps(); // axes on which a box was too far off for floats
};

// The tree of the structure at the end of a chain of transforms, which must be readable; null if
// the structure has motion or a single leaf.
const BlockHeader* standingTree(uint64_t structure) {
    const auto* header = reinterpret_cast<const BlockHeader*>(structure & ~devlib::kTagMask);
    return header && !isMoving(header->type) && header->root != kNoNode &&
                   (header->root & kNodeTagMask) == kInner
               ? header
               : nullptr;
}

// Empty if there are no tight bounds.
math::Box turnedBounds(const float transform[12], const BlockHeader* header, OpenLevels levels) {
    BoxTurner turner;
    turner.setMatrix(transform);
    turner.add(header, header->root, levels.count);
    return turner.box();
}
math::Box boundsOfPoses(const float transform[12], uint64_t handle, OpenLevels levels) {
    const moving::Poses poses(transform, handle);
    const BlockHeader* const header = standingTree(poses.structure());
    if (!header)
        return {};
    BoxTurner turner;
    float margin[3];
    if (!poses.forEach(header->lower, header->upper, margin, [&](const float pose[12]) {
            turner.setMatrix(pose);
            turner.add(header, header->root, levels.count);
        }))
        return {};
    math::Box box = turner.box();
    for (int a = 0; a < 3; ++a) {
        box.lower[a] -= margin[a];
        box.upper[a] += margin[a];
    }
    return box;
}

} // namespace

math::Box instanceBounds(const float transform[12], uint64_t handle, OpenLevels levels) {
    const bool behindTransforms = isTransformTag(handle & devlib::kTagMask);
    math::Box tight;
    if (levels.count != 0 && leadsToBlock(handle)) {
        if (behindTransforms)
            tight = boundsOfPoses(transform, handle, levels);
        else if (const BlockHeader* const header = standingTree(handle))
            tight = turnedBounds(transform, header, levels);
    }
    if (!behindTransforms && !tight.empty())
        return tight;
    const math::Box all = math::transformBox(transform, traversableBounds(handle));
    if (tight.empty())
        return all;
    math::Box both; // either contains the instance
    for (int a = 0; a < 3; ++a) {
        both.lower[a] = std::max(tight.lower[a], all.lower[a]);
        both.upper[a] = std::min(tight.upper[a], all.upper[a]);
    }
    return both.empty() ? all : both;
}

} // namespace sunstone::bvh
