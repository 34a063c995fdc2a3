// SPDX-License-Identifier: Apache-2.0
// Splits references to long thin triangles before a tree is built: the box of a part of such a
// triangle is much smaller than its share of the whole box, so that rays meet fewer boxes. Both
// parts refer to the same triangle.
//
// Which triangles are split, and how often, follows Karras and Aila, "Fast Parallel Construction of
// High-Quality Bounding Volume Hierarchies" (HPG 2013): by the area of the box in excess of the
// triangle's.
#pragma once

#include "bvh/refit/refit.h"

namespace sunstone::bvh {

// In PrimitiveRef::input: marks a further reference to a triangle.
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
