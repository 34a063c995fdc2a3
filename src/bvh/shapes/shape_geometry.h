// SPDX-License-Identifier: Apache-2.0
// Bounds of curves and spheres, computed in double precision from the points in a block. Builders
// on the CPU and on GPUs share this file: it compiles as CUDA too.
#pragma once

#include "bvh/shapes/curves.h"
#include "bvh/shapes/spheres.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

// The ABI of Vec4 does not matter, because no Vec4 crosses the border of an object file.
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpsabi"

namespace sunstone::bvh {

#define SUNSTONE_SHAPES static inline

// Rows of a leaf, the first one included, and its size.
SUNSTONE_SHAPES uint32_t shapeRows(uint32_t shape) {
    return isCurveBasis(shape) ? curveRows(CurveBasis(shape)) : kSphereRows;
}
SUNSTONE_SHAPES uint32_t shapeLeafBytes(uint32_t shape, uint32_t lanes, uint32_t keys) {
    return isCurveBasis(shape) ? curveLeafBytes(CurveBasis(shape), lanes, keys)
                               : sphereLeafBytes(lanes, keys);
}
// Floats of a primitive's points at one key.
SUNSTONE_SHAPES uint32_t shapeFloats(uint32_t shape) {
    return isCurveBasis(shape) ? curvePointFloats(CurveBasis(shape), 1) : 4;
}

// ---- in double precision ----------------------------------------------------------------------

namespace shape_math {

// Coordinates and radii beyond this count as infinite, as kMaxCoordinate in build_input.h.
constexpr double kMaxShapeCoordinate = 0x1p100;

SUNSTONE_SHAPES double magnitude(double a) {
    return __builtin_fabs(a);
}
SUNSTONE_SHAPES double lesser(double a, double b) {
    return b < a ? b : a;
}
SUNSTONE_SHAPES double greater(double a, double b) {
    return a < b ? b : a;
}

// Position and radius.
using Vec4 = double __attribute__((ext_vector_type(4)));

SUNSTONE_SHAPES double dot(const Vec4& a, const Vec4& b) {
    const Vec4 products = a * b;
    return products[0] + products[1] + products[2];
}
SUNSTONE_SHAPES double length(const Vec4& a) {
    return __builtin_sqrt(dot(a, a));
}

// A segment in the power basis, with u from 0 to 1.
struct Polynomial {
    Vec4 a[4];
};
SUNSTONE_SHAPES Polynomial polynomialOf(CurveBasis basis, const float* points) {
    const auto& weights = powerWeights<double>(basis);
    Polynomial whole = {};
    for (uint32_t i = 0; i <= degreeOf(basis); ++i) {
        const float* const p = points + 4 * i;
        const Vec4 point = {p[0], p[1], p[2], p[3]};
        for (int k = 0; k < 4; ++k)
            whole.a[k] = whole.a[k] + weights[k][i] * point;
    }
    return whole;
}

// A part of a segment, with u from 0 to 1 on [begin, begin + length] of the whole.
class Cubic {
public:
    SUNSTONE_INLINE_MEMBER Cubic(const Polynomial& whole, double begin, double length) {
        const Vec4* const w = whole.a;
        const double u = begin, h = length;
        a_[0] = w[0] + u * (w[1] + u * (w[2] + u * w[3]));
        a_[1] = h * (w[1] + u * (2 * w[2] + 3 * u * w[3]));
        a_[2] = h * h * (w[2] + 3 * u * w[3]);
        a_[3] = h * h * h * w[3];
    }
    SUNSTONE_INLINE_MEMBER Vec4 at(double u) const {
        return a_[0] + u * (a_[1] + u * (a_[2] + u * a_[3]));
    }
    SUNSTONE_INLINE_MEMBER Vec4 first(double u) const {
        return a_[1] + u * (2 * a_[2] + 3 * u * a_[3]);
    }
    SUNSTONE_INLINE_MEMBER Vec4 second(double u) const { return 2 * a_[2] + 6 * u * a_[3]; }
    // Control points of the Bernstein basis: the curve is within their hull.
    SUNSTONE_INLINE_MEMBER void hull(Vec4 b[4]) const {
        b[0] = a_[0];
        b[1] = a_[0] + 1.0 / 3 * a_[1];
        b[2] = a_[0] + 2.0 / 3 * a_[1] + 1.0 / 3 * a_[2];
        b[3] = a_[0] + a_[1] + a_[2] + a_[3];
    }
    // The same of the first derivative.
    SUNSTONE_INLINE_MEMBER void hullOfFirst(Vec4 b[3]) const {
        b[0] = a_[1];
        b[1] = a_[1] + a_[2];
        b[2] = a_[1] + 2 * a_[2] + 3 * a_[3];
    }

private:
    Vec4 a_[4];
};

// Rounds to float towards minus infinity. The neighbouring floats must be finite.
SUNSTONE_SHAPES float roundedDown(double a) {
    const float f = float(a);
    const uint32_t bits = __builtin_bit_cast(uint32_t, f), step = f > a;
    if (f == 0)
        return step ? -0x1p-149f : f;
    // Branchless, because half of all numbers would take the branch.
    return __builtin_bit_cast(float, bits + ((bits >> 31) * 2 - 1) * step);
}
SUNSTONE_SHAPES float roundedUp(double a) {
    return -roundedDown(-a);
}

// The fourth component has no meaning.
struct Extent {
    Vec4 lower = __builtin_inf(), upper = -__builtin_inf();

    SUNSTONE_INLINE_MEMBER void extend(const Vec4& p, double radius) {
        const Vec4 below = p - radius, above = p + radius;
        lower = below < lower ? below : lower;
        upper = upper < above ? above : upper;
    }
};

// Radii below zero count as zero for spheres and linear segments.
SUNSTONE_SHAPES double endRadius(const Vec4& p) {
    return greater(p[3], 0.0);
}

// Distance of p from the chord between a and b.
SUNSTONE_SHAPES double fromChord(const Vec4& p, const Vec4& a, const Vec4& b) {
    const Vec4 chord = b - a;
    const double size = dot(chord, chord);
    const double place = size > 0 ? lesser(greater(dot(p - a, chord) / size, 0.0), 1.0) : 0;
    return length(p - (a + place * chord));
}

} // namespace shape_math

// One primitive's points at one motion key: positions and radii of a sphere, or of degree + 1
// control points of a curve's segment. The word of a piece (curves.h) identifies a piece of a
// curve, its number a sphere.
class ShapePoints {
public:
    ShapePoints(uint32_t kind, const float* values) : shape(kind), points(values), whole_{} {
        if (isCurveBasis(kind))
            whole_ = shape_math::polynomialOf(CurveBasis(kind), values);
    }
    // Of a curve.
    SUNSTONE_INLINE_MEMBER shape_math::Cubic part(double begin, double length) const {
        return {whole_, begin, length};
    }
    SUNSTONE_INLINE_MEMBER shape_math::Cubic piece(uint32_t word) const {
        const PieceRange range = rangeOf(word);
        return part(range.begin, range.length);
    }

    const uint32_t shape;
    const float* const points;

private:
    shape_math::Polynomial whole_;
};

// Whether there is a surface: all numbers are finite and not huge, some radius is positive, and the
// control points of a non-linear segment are not all the same.
SUNSTONE_SHAPES bool isActiveShape(uint32_t shape, const float* points) {
    using namespace shape_math;
    const uint32_t floats = shapeFloats(shape);
    bool usable = true, wide = false, apart = false;
    for (uint32_t i = 0; i < floats; ++i) {
        usable = usable && magnitude(double(points[i])) <= kMaxShapeCoordinate;
        wide = wide || (i % 4 == 3 && points[i] > 0);
        apart = apart || (i % 4 != 3 && points[i] != points[i % 4]);
    }
    const bool pointLike = !isCurveBasis(shape) || CurveBasis(shape) == CurveBasis::kLinear;
    return usable && wide && (apart || pointLike);
}

// A box around the piece.
SUNSTONE_SHAPES void shapeBox(const ShapePoints& at, uint32_t word, float lower[3],
                              float upper[3]) {
    using namespace shape_math;
    Extent box;
    if (!isCurveBasis(at.shape)) {
        const Vec4 p = {at.points[0], at.points[1], at.points[2], at.points[3]};
        box.extend(p, endRadius(p));
    } else {
        const CurveBasis basis = CurveBasis(at.shape);
        const PieceRange range = rangeOf(word);
        // Two hulls are tighter than one.
        const bool isLinear = basis == CurveBasis::kLinear;
        const int parts = isLinear ? 1 : 2;
        for (int part = 0; part < parts; ++part) {
            Vec4 b[4];
            const double length = double(range.length) / parts;
            at.part(range.begin + part * length, length).hull(b);
            for (int i = 0; i < 4; i += isLinear ? 3 : 1)
                box.extend(b[i], isLinear ? endRadius(b[i]) : magnitude(b[i][3]));
        }
    }
    for (int i = 0; i < 3; ++i) {
        lower[i] = roundedDown(box.lower[i]);
        upper[i] = roundedUp(box.upper[i]);
    }
}

// A leaf's data of the piece at one motion key: the rows after the first (curves.h, spheres.h).
SUNSTONE_SHAPES void shapeLane(uint32_t shape, const float* points, uint32_t word, bool moving,
                               float* rows) {
    using namespace shape_math;
    if (!isCurveBasis(shape)) {
        for (int i = 0; i < 4; ++i)
            rows[i] = points[i];
        return;
    }
    if (CurveBasis(shape) == CurveBasis::kLinear) {
        for (int end = 0; end < 2; ++end) {
            const float radius = points[4 * end + 3];
            for (int i = 0; i < 3; ++i)
                rows[3 * end + i] = points[4 * end + i];
            rows[6 + end] = radius > 0 ? radius : 0;
        }
        return;
    }
    Vec4 b[4];
    ShapePoints(shape, points).piece(word).hull(b);
    double radius = greater(magnitude(b[0][3]), magnitude(b[3][3]));
    for (int i = 1; i < 3; ++i) {
        // Distances from fixed places on the chord can be interpolated between keys.
        const double distance =
            moving ? length(b[i] - (b[0] + i / 3.0 * (b[3] - b[0]))) : fromChord(b[i], b[0], b[3]);
        radius = greater(radius, distance + magnitude(b[i][3]));
    }
    double shift = 0, largest = 0; // by rounding of the ends; coordinate
    for (int end = 0; end < 2; ++end)
        for (int i = 0; i < 3; ++i) {
            const double exact = b[3 * end][i];
            rows[3 * end + i] = float(exact);
            shift = greater(shift, magnitude(exact - float(exact)));
            largest = greater(largest, magnitude(exact));
        }
    // Covers the rounding of interpolated chords and control points, a few units in the last place.
    rows[6] = roundedUp(radius + 2 * shift + (moving ? 0x1p-20 * largest : 0));
}

// Whether bounds of the derivatives prove that turnsMuch() is false, at a fraction of its cost.
// `away` is a lower bound of the speed along the chord, times the chord's length; `most` the
// largest second derivative, squared.
SUNSTONE_SHAPES bool isSurelyStraight(const shape_math::Cubic& piece) {
    using namespace shape_math;
    Vec4 b[4], d[3];
    piece.hull(b);
    piece.hullOfFirst(d);
    const Vec4 chord = b[3] - b[0];
    double away = __builtin_inf(), most = 0, radius = 0;
    for (const Vec4& each : d)
        away = lesser(away, dot(each, chord));
    for (int end = 0; end < 2; ++end) {
        const Vec4 second = piece.second(end);
        most = greater(most, dot(second, second));
    }
    for (const Vec4& each : b)
        radius = greater(radius, magnitude(each[3]));
    constexpr double kMargin = 1.0001; // for rounding
    const double size = dot(chord, chord);
    if (!(away > 0 && size > 0x1p-200 && away < 0x1p200))
        return false;
    const double slowest = away * away / size; // lower bound of the squared speed
    return kMargin * most <= 4 * slowest &&
           kMargin * most * radius * radius <= 0.0625 * slowest * slowest;
}

// Whether the direction of a piece changes much within an eighth of it, or the piece is thick
// relative to its curvature.
SUNSTONE_SHAPES bool turnsMuch(const shape_math::Cubic& piece) {
    using namespace shape_math;
    constexpr double kStep = 1.0 / 16;
    for (int i = 0; i <= 16; ++i) {
        const double u = i * kStep;
        const Vec4 d = piece.first(u), dd = piece.second(u);
        const double speed = dot(d, d), along = dot(d, dd);
        const double bend = __builtin_sqrt(greater(dot(dd, dd) * speed - along * along, 0.0));
        // The change of direction over an eighth, the ratio of radius to radius of curvature, and
        // the change of the parameter's speed over half an eighth.
        if (!(bend * 2 * kStep <= 0.25 * speed) ||
            !(bend * magnitude(piece.at(u)[3]) <= 0.25 * speed * __builtin_sqrt(speed)) ||
            !(magnitude(along) * kStep <= 0.5 * speed))
            return true;
    }
    return false;
}

SUNSTONE_SHAPES bool isBentPiece(const ShapePoints& at, uint32_t word) {
    if (!isCurveBasis(at.shape) || CurveBasis(at.shape) == CurveBasis::kLinear)
        return false;
    const shape_math::Cubic piece = at.piece(word);
    return !isSurelyStraight(piece) && turnsMuch(piece);
}

// Boxes of a curve's pieces.
struct PieceBoxes {
    struct {
        float lower[3], upper[3];
    } of[kMaxPieces];
};

SUNSTONE_SHAPES void boxesOfPieces(const ShapePoints& at, uint32_t pieces, PieceBoxes& boxes) {
    for (uint32_t place = 0; place < pieces; ++place)
        shapeBox(at, pieceWord(0, pieces + place), boxes.of[place].lower, boxes.of[place].upper);
}

// Half the area of the boxes of that many pieces.
SUNSTONE_SHAPES float areaOfPieces(const PieceBoxes& boxes, uint32_t pieces) {
    float area = 0;
    for (uint32_t place = 0; place < pieces; ++place) {
        const auto& [lower, upper] = boxes.of[place];
        const float x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
        area += x * y + y * z + z * x;
    }
    return area;
}

// The number of pieces into which to split a curve's segment: a power of two up to the limit.
// `boxes` has the box of the whole segment and receives those of the pieces. Thin segments oblique
// to the axes gain most.
SUNSTONE_SHAPES uint32_t worthwhilePieces(const ShapePoints& at, uint32_t limit,
                                          PieceBoxes& boxes) {
    uint32_t count = 1;
    for (float area = areaOfPieces(boxes, 1); count < limit; count *= 2) {
        PieceBoxes parts;
        boxesOfPieces(at, 2 * count, parts);
        const float split = areaOfPieces(parts, 2 * count);
        if (split > 0.8f * area)
            break;
        area = split;
        boxes = parts;
    }
    return count;
}

// Whether some of that many pieces bend.
SUNSTONE_SHAPES bool anyBends(const ShapePoints& at, uint32_t pieces) {
    bool bends = false;
    for (uint32_t place = pieces; place < 2 * pieces && !bends; ++place)
        bends = isBentPiece(at, pieceWord(0, place));
    return bends;
}

} // namespace sunstone::bvh

#pragma clang diagnostic pop

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
