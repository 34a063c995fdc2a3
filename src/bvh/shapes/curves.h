// SPDX-License-Identifier: Apache-2.0
// Round curves in acceleration structures: their bases, their data in a block, and bounds.
//
// A segment is a polynomial in u in [0, 1] of positions and radii, given by degree + 1 control
// points of a basis. Its surface is what a circle of radius r(u) about C(u), orthogonal to C'(u),
// sweeps; linear segments have spheres at both ends, the other bases are open there, or closed by
// flat discs at the ends of strands. Parts with a radius below zero have no surface.
//
// A block of curves holds two arrays before the nodes,
//   points   float4[degree + 1] per segment (position, radius), with motion at each key in turn
//   records  ShapeRecord per segment
// and leaves of pieces: parts of segments between two parameters, each bounded by a capsule (all
// points within a radius of its chord). A word with segment and place identifies a piece. Segments
// are split into pieces only for tighter boxes.
//
// Read next: curves_body.h, the intersection test.
#pragma once

#include "base/inline.h"
#include "bvh/layout.h"

#include <cstdint>

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh {

// Numbers of OptixPrimitiveType.
enum class CurveBasis : uint32_t {
    kQuadraticBSpline = 0x2501,
    kCubicBSpline = 0x2502,
    kLinear = 0x2503,
    kCatmullRom = 0x2504,
};

SUNSTONE_INLINE bool isCurveBasis(uint32_t number) {
    return number >= 0x2501 && number <= 0x2504;
}
SUNSTONE_INLINE uint32_t degreeOf(CurveBasis basis) {
    return basis == CurveBasis::kLinear ? 1 : basis == CurveBasis::kQuadraticBSpline ? 2 : 3;
}

// A word with a segment and a place on it. Place 1 is the whole segment, 2 and 3 are its halves, 4
// to 7 its quarters, 8 to 15 its eighths.
constexpr uint32_t kPieceBits = 4;
constexpr uint32_t kMaxPieces = 1u << (kPieceBits - 1);
constexpr uint32_t kMaxCurveSegments = 1u << (32 - kPieceBits);
SUNSTONE_INLINE uint32_t pieceWord(uint32_t segment, uint32_t place) {
    return segment << kPieceBits | place;
}
SUNSTONE_INLINE uint32_t segmentOf(uint32_t word) {
    return word >> kPieceBits;
}
struct PieceRange {
    float begin, length;
};
SUNSTONE_INLINE PieceRange rangeOf(uint32_t word) {
    const uint32_t place = word & ((1u << kPieceBits) - 1);
    const uint32_t parts = place >= 8 ? 8 : place >= 4 ? 4 : place >= 2 ? 2 : 1;
    return {float(place - parts) / float(parts), 1.0f / float(parts)};
}

// A word (not a number) for an unused lane of a leaf.
constexpr uint32_t kNoPiece = ~0u;

// Up to N pieces: rows of N words. Rows 1 to 3 and 4 to 6 are the ends of the chord, row 7 is the
// capsule's radius; of linear segments rows 7 and 8 are the radii at the ends. Unused lanes have
// kNoPiece, and NaN in all other rows; so have lanes of inactive segments. With motion, rows 1 to
// the last follow for each later key, and the radius is measured from fixed places on the chord (a
// third of it for each control point), so that the interpolated capsule contains the piece at any
// time.
constexpr uint32_t kCurveRows = 8, kLinearRows = 9;
SUNSTONE_INLINE uint32_t curveRows(CurveBasis basis) {
    return basis == CurveBasis::kLinear ? kLinearRows : kCurveRows;
}
SUNSTONE_INLINE uint32_t curveLeafBytes(CurveBasis basis, uint32_t lanes, uint32_t keys) {
    const uint32_t rows = curveRows(basis) + (keys - 1) * (curveRows(basis) - 1);
    return (rows * lanes * 4 + kRefUnit - 1) / kRefUnit * kRefUnit;
}

// Numbers of a segment in the array of points.
SUNSTONE_INLINE uint32_t curvePointFloats(CurveBasis basis, uint32_t keys) {
    return 4 * (degreeOf(basis) + 1) * keys;
}

// Rows of weights of the power basis coefficients by control point, for any basis (unused: 0).
template <class Real>
SUNSTONE_INLINE const Real (&powerWeights(CurveBasis basis))[4][4] {
    constexpr Real kHalf = Real(0.5), kSixth = Real(1) / 6;
    static constexpr Real kLinear[4][4] = {{1, 0, 0, 0}, {-1, 1, 0, 0}};
    static constexpr Real kQuadratic[4][4] = {
        {kHalf, kHalf, 0, 0}, {-1, 1, 0, 0}, {kHalf, -1, kHalf, 0}};
    static constexpr Real kCubic[4][4] = {{kSixth, Real(4) / 6, kSixth, 0},
                                          {-kHalf, 0, kHalf, 0},
                                          {kHalf, -1, kHalf, 0},
                                          {-kSixth, kHalf, -kHalf, kSixth}};
    static constexpr Real kCatmull[4][4] = {{0, 1, 0, 0},
                                            {-kHalf, 0, kHalf, 0},
                                            {1, Real(-2.5), 2, -kHalf},
                                            {-kHalf, Real(1.5), Real(-1.5), kHalf}};
    switch (basis) {
    case CurveBasis::kLinear:
        return kLinear;
    case CurveBasis::kQuadraticBSpline:
        return kQuadratic;
    case CurveBasis::kCubicBSpline:
        return kCubic;
    default:
        return kCatmull;
    }
}

} // namespace sunstone::bvh

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
