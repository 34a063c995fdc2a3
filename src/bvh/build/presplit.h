// SPDX-License-Identifier: Apache-2.0
// Splits references to long thin triangles before a tree is built. The boxes of the parts of such a
// triangle are together much smaller than its whole box, so rays meet fewer boxes. Both parts refer
// to the same triangle.
//
// The choice of triangles and the number of splits follow Karras and Aila, "Fast Parallel
// Construction of High-Quality Bounding Volume Hierarchies" (HPG 2013): the criterion is the area
// of the box in excess of the triangle's need.
#pragma once

#include "bvh/refit/refit.h"

namespace sunstone::bvh {

// In PrimitiveRef::input: marks a further reference to a triangle.
constexpr uint32_t kDuplicate = 1u << 31;

constexpr uint64_t kMaxSplits = 1u << 23;

// The number of references that splitting may add to `count`; it never decreases with `count`.
inline uint64_t maxSplits(uint64_t count) {
    return count < kMaxSplits ? count : kMaxSplits;
}

// Appends up to maxSplits(count) references; returns the new count. `spare` has room for `count`
// floats. Does not split triangles that may run their any-hit program only once per ray.
uint32_t splitLongTriangles(PrimitiveRef* references, uint32_t count, const Sources& sources,
                            float* spare);

} // namespace sunstone::bvh
