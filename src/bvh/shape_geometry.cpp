// SPDX-License-Identifier: Apache-2.0
#include "bvh/shape_geometry.h"

#include "bvh/build_input.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sunstone::bvh {
namespace {

// Position and radius.
struct Vec4 {
    double v[4];

    friend Vec4 operator+(const Vec4& a, const Vec4& b) {
        return {{a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2], a.v[3] + b.v[3]}};
    }
    friend Vec4 operator*(double s, const Vec4& a) {
        return {{s * a.v[0], s * a.v[1], s * a.v[2], s * a.v[3]}};
    }
    friend Vec4 operator-(const Vec4& a, const Vec4& b) { return a + -1 * b; }
};
double dot(const Vec4& a, const Vec4& b) {
    return a.v[0] * b.v[0] + a.v[1] * b.v[1] + a.v[2] * b.v[2];
}
double length(const Vec4& a) {
    return std::sqrt(dot(a, a));
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
                const double w = std::round(double(weights[k][i]) * 6) / 6;
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

float roundedDown(double a) {
    const float f = float(a);
    return f > a ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float roundedUp(double a) {
    return -roundedDown(-a);
}

void extend(double lower[3], double upper[3], const Vec4& p, double radius) {
    for (int i = 0; i < 3; ++i) {
        lower[i] = std::min(lower[i], p.v[i] - radius);
        upper[i] = std::max(upper[i], p.v[i] + radius);
    }
}

// Radii below zero count as zero where the shape is a sphere or between spheres.
double endRadius(const Vec4& p) {
    return std::max(p.v[3], 0.0);
}

// Distance of p from the chord between a and b.
double fromChord(const Vec4& p, const Vec4& a, const Vec4& b) {
    const Vec4 chord = b - a;
    const double size = dot(chord, chord);
    const double place = size > 0 ? std::clamp(dot(p - a, chord) / size, 0.0, 1.0) : 0;
    return length(p - (a + place * chord));
}

} // namespace

bool isActiveShape(const ShapePoints& at) {
    const uint32_t floats = shapeFloats(at.shape);
    bool usable = true, wide = false, apart = false;
    for (uint32_t i = 0; i < floats; ++i) {
        usable = usable && std::fabs(at.points[i]) <= kMaxCoordinate;
        wide = wide || (i % 4 == 3 && at.points[i] > 0);
        apart = apart || (i % 4 != 3 && at.points[i] != at.points[i % 4]);
    }
    const bool pointLike =
        !isCurveBasis(at.shape) || CurveBasis(at.shape) == CurveBasis::kLinear;
    return usable && wide && (apart || pointLike);
}

void shapeBox(const ShapePoints& at, uint32_t word, float lower[3], float upper[3]) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
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
                extend(low, high, p, parts == 1 ? endRadius(p) : std::fabs(p.v[3]));
        }
    }
    for (int i = 0; i < 3; ++i) {
        lower[i] = roundedDown(low[i]);
        upper[i] = roundedUp(high[i]);
    }
}

void shapeLane(const ShapePoints& at, uint32_t word, bool moving, float* rows) {
    if (!isCurveBasis(at.shape)) {
        std::copy(at.points, at.points + 4, rows);
        return;
    }
    const CurveBasis basis = CurveBasis(at.shape);
    if (basis == CurveBasis::kLinear) {
        for (int end = 0; end < 2; ++end) {
            std::copy(at.points + 4 * end, at.points + 4 * end + 3, rows + 3 * end);
            rows[6 + end] = std::max(at.points[4 * end + 3], 0.0f);
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
        radius = std::max(radius, distance + std::fabs(b[i].v[3]));
    }
    double shift = 0, largest = 0; // by rounding of the ends; coordinate
    for (int end = 0; end < 2; ++end)
        for (int i = 0; i < 3; ++i) {
            const double exact = b[3 * end].v[i];
            rows[3 * end + i] = float(exact);
            shift = std::max(shift, std::fabs(exact - float(exact)));
            largest = std::max(largest, std::fabs(exact));
        }
    // Interpolation rounds chords and control points by a few units in the last place.
    rows[6] = roundedUp(radius + 2 * shift + (moving ? 0x1p-20 * largest : 0));
}

bool isBentPiece(const ShapePoints& at, uint32_t word) {
    if (!isCurveBasis(at.shape) || CurveBasis(at.shape) == CurveBasis::kLinear)
        return false;
    const PieceRange range = rangeOf(word);
    const Cubic piece(CurveBasis(at.shape), at.points, range.begin, range.length);
    constexpr double kStep = 1.0 / 16;
    for (int i = 0; i <= 16; ++i) {
        const double u = i * kStep;
        const Vec4 d = piece.first(u), dd = piece.second(u);
        const double speed = dot(d, d), along = dot(d, dd);
        const double bend = std::sqrt(std::max(dot(dd, dd) * speed - along * along, 0.0));
        // The turn over an eighth, the ratio of radius and radius of curvature, and how the
        // parameter's speed changes over half an eighth.
        if (!(bend * 2 * kStep <= 0.25 * speed) ||
            !(bend * std::fabs(piece.at(u).v[3]) <= 0.25 * speed * std::sqrt(speed)) ||
            !(std::fabs(along) * kStep <= 0.5 * speed))
            return true;
    }
    return false;
}

} // namespace sunstone::bvh
