// SPDX-License-Identifier: Apache-2.0
// Bounds of curves and spheres, computed in double precision from the points in a block. Builders
// on the CPU and on GPUs share this file: it compiles as CUDA too.
#pragma once

#include "bvh/shapes/curves.h"
#include "bvh/shapes/spheres.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh {

#define SUNSTONE_SHAPES static inline

// One primitive's points at one motion key: degree + 1 control points of a curve's segment, or a
// sphere; positions and radii. A piece of a curve is named by its word (curves.h), a sphere by its
// number.
struct ShapePoints {
    uint32_t shape;
    const float* points;
};

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
struct Vec4 {
    double v[4];

    friend constexpr Vec4 operator+(const Vec4& a, const Vec4& b) {
        return {{a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2], a.v[3] + b.v[3]}};
    }
    friend constexpr Vec4 operator*(double s, const Vec4& a) {
        return {{s * a.v[0], s * a.v[1], s * a.v[2], s * a.v[3]}};
    }
    friend constexpr Vec4 operator-(const Vec4& a, const Vec4& b) { return a + -1 * b; }
};
SUNSTONE_SHAPES double dot(const Vec4& a, const Vec4& b) {
    return a.v[0] * b.v[0] + a.v[1] * b.v[1] + a.v[2] * b.v[2];
}
SUNSTONE_SHAPES double length(const Vec4& a) {
    return __builtin_sqrt(dot(a, a));
}

// A segment in the power basis, with u from 0 to 1 on [begin, begin + length] of the whole.
class Cubic {
public:
    Cubic(CurveBasis basis, const float* points, double begin, double length) {
        const auto& weights = powerWeights(basis);
        Vec4 whole[4] = {};
        for (int k = 0; k < 4; ++k)
            for (uint32_t i = 0; i <= degreeOf(basis); ++i) {
                const float* p = points + 4 * i;
                // Sixths are not exact as floats.
                const double six = double(weights[k][i]) * 6;
                const double w = double(int(six + (six < 0 ? -0.5 : 0.5))) / 6;
                whole[k] = whole[k] + w * Vec4{{p[0], p[1], p[2], p[3]}};
            }
        const double u = begin, h = length;
        a_[0] = whole[0] + u * (whole[1] + u * (whole[2] + u * whole[3]));
        a_[1] = h * (whole[1] + u * (2 * whole[2] + 3 * u * whole[3]));
        a_[2] = h * h * (whole[2] + 3 * u * whole[3]);
        a_[3] = h * h * h * whole[3];
    }
    Vec4 at(double u) const { return a_[0] + u * (a_[1] + u * (a_[2] + u * a_[3])); }
    Vec4 first(double u) const { return a_[1] + u * (2 * a_[2] + 3 * u * a_[3]); }
    Vec4 second(double u) const { return 2 * a_[2] + 6 * u * a_[3]; }
    // Control points of the Bernstein basis: the curve is within their hull.
    void hull(Vec4 b[4]) const {
        b[0] = a_[0];
        b[1] = a_[0] + 1.0 / 3 * a_[1];
        b[2] = a_[0] + 2.0 / 3 * a_[1] + 1.0 / 3 * a_[2];
        b[3] = a_[0] + a_[1] + a_[2] + a_[3];
    }

private:
    Vec4 a_[4];
};

// The next float towards minus infinity, of one that is finite.
SUNSTONE_SHAPES float nextBelow(float a) {
    const uint32_t bits = __builtin_bit_cast(uint32_t, a);
    if (a == 0)
        return -0x1p-149f;
    return __builtin_bit_cast(float, bits >> 31 ? bits + 1 : bits - 1);
}
SUNSTONE_SHAPES float roundedDown(double a) {
    const float f = float(a);
    return f > a ? nextBelow(f) : f;
}
SUNSTONE_SHAPES float roundedUp(double a) {
    return -roundedDown(-a);
}

SUNSTONE_SHAPES void extend(double lower[3], double upper[3], const Vec4& p, double radius) {
    for (int i = 0; i < 3; ++i) {
        lower[i] = lesser(lower[i], p.v[i] - radius);
        upper[i] = greater(upper[i], p.v[i] + radius);
    }
}

// Radii below zero count as zero where the shape is a sphere or between spheres.
SUNSTONE_SHAPES double endRadius(const Vec4& p) {
    return greater(p.v[3], 0.0);
}

// Distance of p from the chord between a and b.
SUNSTONE_SHAPES double fromChord(const Vec4& p, const Vec4& a, const Vec4& b) {
    const Vec4 chord = b - a;
    const double size = dot(chord, chord);
    const double place = size > 0 ? lesser(greater(dot(p - a, chord) / size, 0.0), 1.0) : 0;
    return length(p - (a + place * chord));
}

} // namespace shape_math

// Whether there is a surface: all numbers are finite and not huge, some radius is positive, and the
// control points of a non-linear segment are not all the same.
SUNSTONE_SHAPES bool isActiveShape(const ShapePoints& at) {
    using namespace shape_math;
    const uint32_t floats = shapeFloats(at.shape);
    bool usable = true, wide = false, apart = false;
    for (uint32_t i = 0; i < floats; ++i) {
        usable = usable && magnitude(double(at.points[i])) <= kMaxShapeCoordinate;
        wide = wide || (i % 4 == 3 && at.points[i] > 0);
        apart = apart || (i % 4 != 3 && at.points[i] != at.points[i % 4]);
    }
    const bool pointLike = !isCurveBasis(at.shape) || CurveBasis(at.shape) == CurveBasis::kLinear;
    return usable && wide && (apart || pointLike);
}

// A box around the piece.
SUNSTONE_SHAPES void shapeBox(const ShapePoints& at, uint32_t word, float lower[3],
                              float upper[3]) {
    using namespace shape_math;
    constexpr double kInf = __builtin_inf();
    double low[3] = {kInf, kInf, kInf}, high[3] = {-kInf, -kInf, -kInf};
    if (!isCurveBasis(at.shape)) {
        const Vec4 p = {{at.points[0], at.points[1], at.points[2], at.points[3]}};
        extend(low, high, p, endRadius(p));
    } else {
        const CurveBasis basis = CurveBasis(at.shape);
        const PieceRange range = rangeOf(word);
        // Two hulls are closer than one.
        const int parts = basis == CurveBasis::kLinear ? 1 : 2;
        for (int part = 0; part < parts; ++part) {
            Vec4 b[4];
            const double length = double(range.length) / parts;
            Cubic(basis, at.points, range.begin + part * length, length).hull(b);
            for (const Vec4& p : b)
                extend(low, high, p, parts == 1 ? endRadius(p) : magnitude(p.v[3]));
        }
    }
    for (int i = 0; i < 3; ++i) {
        lower[i] = roundedDown(low[i]);
        upper[i] = roundedUp(high[i]);
    }
}

// A leaf's data of the piece at one motion key: the rows after the first (curves.h, spheres.h).
SUNSTONE_SHAPES void shapeLane(const ShapePoints& at, uint32_t word, bool moving, float* rows) {
    using namespace shape_math;
    if (!isCurveBasis(at.shape)) {
        for (int i = 0; i < 4; ++i)
            rows[i] = at.points[i];
        return;
    }
    const CurveBasis basis = CurveBasis(at.shape);
    if (basis == CurveBasis::kLinear) {
        for (int end = 0; end < 2; ++end) {
            const float radius = at.points[4 * end + 3];
            for (int i = 0; i < 3; ++i)
                rows[3 * end + i] = at.points[4 * end + i];
            rows[6 + end] = radius > 0 ? radius : 0;
        }
        return;
    }
    const PieceRange range = rangeOf(word);
    Vec4 b[4];
    Cubic(basis, at.points, range.begin, range.length).hull(b);
    double radius = 0;
    for (int i = 0; i < 4; ++i) {
        // Distances from fixed places on the chord can be interpolated between keys.
        const double distance =
            moving ? length(b[i] - (b[0] + i / 3.0 * (b[3] - b[0]))) : fromChord(b[i], b[0], b[3]);
        radius = greater(radius, distance + magnitude(b[i].v[3]));
    }
    double shift = 0, largest = 0; // by rounding of the ends; coordinate
    for (int end = 0; end < 2; ++end)
        for (int i = 0; i < 3; ++i) {
            const double exact = b[3 * end].v[i];
            rows[3 * end + i] = float(exact);
            shift = greater(shift, magnitude(exact - float(exact)));
            largest = greater(largest, magnitude(exact));
        }
    // Interpolation rounds chords and control points by a few units in the last place.
    rows[6] = roundedUp(radius + 2 * shift + (moving ? 0x1p-20 * largest : 0));
}

// Whether the piece turns much within an eighth of it, or is thick for its curvature.
SUNSTONE_SHAPES bool isBentPiece(const ShapePoints& at, uint32_t word) {
    using namespace shape_math;
    if (!isCurveBasis(at.shape) || CurveBasis(at.shape) == CurveBasis::kLinear)
        return false;
    const PieceRange range = rangeOf(word);
    const Cubic piece(CurveBasis(at.shape), at.points, range.begin, range.length);
    constexpr double kStep = 1.0 / 16;
    for (int i = 0; i <= 16; ++i) {
        const double u = i * kStep;
        const Vec4 d = piece.first(u), dd = piece.second(u);
        const double speed = dot(d, d), along = dot(d, dd);
        const double bend = __builtin_sqrt(greater(dot(dd, dd) * speed - along * along, 0.0));
        // The turn over an eighth, the ratio of radius and radius of curvature, and how the
        // parameter's speed changes over half an eighth.
        if (!(bend * 2 * kStep <= 0.25 * speed) ||
            !(bend * magnitude(piece.at(u).v[3]) <= 0.25 * speed * __builtin_sqrt(speed)) ||
            !(magnitude(along) * kStep <= 0.5 * speed))
            return true;
    }
    return false;
}

// Half the area of the boxes of that many pieces.
SUNSTONE_SHAPES float areaOfPieces(const ShapePoints& at, uint32_t pieces) {
    float area = 0;
    for (uint32_t place = pieces; place < 2 * pieces; ++place) {
        float lower[3], upper[3];
        shapeBox(at, pieceWord(0, place), lower, upper);
        const float x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
        area += x * y + y * z + z * x;
    }
    return area;
}

// Into how many pieces to split a curve's segment: a power of two up to the limit. Thin things
// across the axes gain most.
SUNSTONE_SHAPES uint32_t worthwhilePieces(const ShapePoints& at, uint32_t limit) {
    uint32_t count = 1;
    for (float area = limit > 1 ? areaOfPieces(at, 1) : 0; count < limit; count *= 2) {
        const float split = areaOfPieces(at, 2 * count);
        if (split > 0.8f * area)
            break;
        area = split;
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

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
