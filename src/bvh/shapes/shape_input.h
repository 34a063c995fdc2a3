// SPDX-License-Identifier: Apache-2.0
// Reads curves and spheres from build inputs into the arrays of a block. A segment or sphere is
// inactive if an index is out of range or it has no surface (isActiveShape) at some motion key.
#pragma once

#include "bvh/build/build.h"
#include "bvh/layout.h"

namespace sunstone::bvh {

// Whether the inputs are curves or spheres, and their common properties.
inline bool hasShapes(const BuildInputs& inputs) {
    return !inputs.curves.empty() || !inputs.spheres.empty();
}
inline uint32_t numShapeInputs(const BuildInputs& inputs) {
    return uint32_t(inputs.curves.empty() ? inputs.spheres.size() : inputs.curves.size());
}
uint32_t shapeOf(const BuildInputs& inputs);
uint32_t shapeCount(const BuildInputs& inputs, uint32_t input);
const SbtInput& shapeSbt(const BuildInputs& inputs, uint32_t input);

// Throws Error(kInvalidValue) unless all inputs are of one type of shapes.
void requireOneShape(const BuildInputs& inputs);

// The most pieces of a segment.
uint32_t maxPieces(uint32_t shape, const BuildOptions& options);

// The formats of a curve or sphere input, which must be equal in an update.
InputRecord shapeInputRecord(const BuildInputs& inputs, uint32_t i, uint32_t firstSbt,
                             uint32_t firstPrimitive);

// The arrays of a block, and the places of a primitive's points.
struct ShapeStore {
    uint32_t shape, keys;
    float* points;
    ShapeRecord* records;

    explicit ShapeStore(void* block);
    const float* pointsOf(uint32_t number, uint32_t key) const;
    bool active(uint32_t number) const { return !(records[number].flags & kShapeInactive); }

    // Fills the arrays from the inputs, except the flag kCurveBent.
    void read(const BuildInputs& inputs) const;
};

} // namespace sunstone::bvh
