// SPDX-License-Identifier: Apache-2.0
// Bounds of curves and spheres, computed in double precision from the points a block holds.
#pragma once

#include "bvh/curves.h"
#include "bvh/spheres.h"

namespace sunstone::bvh {

// One primitive's points at one motion key: degree + 1 control points of a curve's segment, or a
// sphere; positions and radii. A piece of a curve is named by its word (curves.h), a sphere by its
// number.
struct ShapePoints {
    uint32_t shape;
    const float* points;
};

// Whether there is a surface: all numbers are finite and not huge, some radius is positive, and the
// control points of a non-linear segment are not all the same.
bool isActiveShape(const ShapePoints& at);

// A box around the piece.
void shapeBox(const ShapePoints& at, uint32_t word, float lower[3], float upper[3]);

// What a leaf holds of the piece at one motion key: the rows after the first (curves.h, spheres.h).
void shapeLane(const ShapePoints& at, uint32_t word, bool moving, float* rows);

// Whether the piece turns much within an eighth of it, or is thick for its curvature.
bool isBentPiece(const ShapePoints& at, uint32_t word);

// Rows of a leaf, the first one included, and its size.
inline uint32_t shapeRows(uint32_t shape) {
    return isCurveBasis(shape) ? curveRows(CurveBasis(shape)) : kSphereRows;
}
inline uint32_t shapeLeafBytes(uint32_t shape, uint32_t lanes, uint32_t keys) {
    return isCurveBasis(shape) ? curveLeafBytes(CurveBasis(shape), lanes, keys)
                               : sphereLeafBytes(lanes, keys);
}
// Floats of a primitive's points at one key.
inline uint32_t shapeFloats(uint32_t shape) {
    return isCurveBasis(shape) ? curvePointFloats(CurveBasis(shape), 1) : 4;
}

} // namespace sunstone::bvh
