// SPDX-License-Identifier: Apache-2.0
// Splits references to long thin triangles before a tree is built: a box around a part of such a
// triangle is much smaller than its share of the box around the whole, and rays that pass by the
// triangle meet fewer boxes. Both parts refer to the same triangle.
//
// Which triangles, how often: after Karras and Aila, "Fast Parallel Construction of High-Quality
// Bounding Volume Hierarchies" (HPG 2013): by what the box has more than the triangle needs.
#pragma once

#include "bvh/refit/refit.h"

namespace sunstone::bvh {

// In PrimitiveRef::input: a further reference to a triangle that has one without the mark.
constexpr uint32_t kDuplicate = 1u << 31;

constexpr uint64_t kMaxSplits = 1u << 23;

// References that splitting may add to `count`; never fewer for more.
inline uint64_t maxSplits(uint64_t count) {
    return count < kMaxSplits ? count : kMaxSplits;
}

// Appends up to maxSplits(count) references; returns the new count. `spare` has room for `count`
// floats. Triangles that must meet any-hit programs once are left alone.
uint32_t splitLongTriangles(PrimitiveRef* references, uint32_t count, const Sources& sources,
                            float* spare);

} // namespace sunstone::bvh
