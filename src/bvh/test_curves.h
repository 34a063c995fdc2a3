// SPDX-License-Identifier: Apache-2.0
// For tests: a judge of rays against round curves in double precision. It cuts a segment into
// many short truncated cones along chords, which differ from the surface by less than the judge's
// tolerance, and knows nothing of how the kernels look for hits.
#pragma once

#include "bvh/curves.h"
#include "bvh/shapes.h"
#include "bvh/test_meshes.h"

#include <algorithm>
#include <optional>

namespace sunstone::bvh::testing {

struct Vec3d {
    double x, y, z;
    friend Vec3d operator+(Vec3d a, Vec3d b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Vec3d operator-(Vec3d a, Vec3d b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Vec3d operator*(double s, Vec3d a) { return {s * a.x, s * a.y, s * a.z}; }
};
inline double dot(Vec3d a, Vec3d b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline double length(Vec3d a) {
    return std::sqrt(dot(a, a));
}

// Control points of a segment; unused ones zero.
struct Segment {
    CurveBasis basis;
    std::array<std::array<float, 4>, 4> points{};
    bool capBegin = false, capEnd = false;
};

struct CurvePoint {
    Vec3d position;
    double radius;
};

// Straight from the definitions of the bases.
inline CurvePoint evaluate(const Segment& s, double u) {
    double w[4] = {};
    const double v = 1 - u;
    switch (s.basis) {
    case CurveBasis::kLinear:
        w[0] = v, w[1] = u;
        break;
    case CurveBasis::kQuadraticBSpline:
        w[0] = v * v / 2, w[1] = (1 + 2 * u - 2 * u * u) / 2, w[2] = u * u / 2;
        break;
    case CurveBasis::kCubicBSpline:
        w[0] = v * v * v / 6, w[1] = (4 - 6 * u * u + 3 * u * u * u) / 6;
        w[2] = (1 + 3 * u + 3 * u * u - 3 * u * u * u) / 6, w[3] = u * u * u / 6;
        break;
    case CurveBasis::kCatmullRom:
        w[0] = (-u + 2 * u * u - u * u * u) / 2, w[1] = (2 - 5 * u * u + 3 * u * u * u) / 2;
        w[2] = (u + 4 * u * u - 3 * u * u * u) / 2, w[3] = (-u * u + u * u * u) / 2;
        break;
    }
    CurvePoint p{};
    for (int i = 0; i < 4; ++i) {
        const auto& c = s.points[size_t(i)];
        p.position = p.position + w[i] * Vec3d{c[0], c[1], c[2]};
        p.radius += w[i] * c[3];
    }
    return p;
}

struct JudgedHit {
    double t, u;
};

// How the judge leans: radii scaled, ends moved inwards, where it is unsure.
struct Lean {
    double radius = 1;
    double ends = 0;
};

class CurveJudge {
public:
    CurveJudge(const Segment& segment, Lean lean, int cuts = 600)
        : segment_(segment), lean_(lean), cuts_(cuts) {}

    std::optional<JudgedHit> nearest(const ShapeRay& ray) const {
        best_.reset();
        ray_ = &ray;
        org_ = {ray.origin[0], ray.origin[1], ray.origin[2]};
        dir_ = {ray.direction[0], ray.direction[1], ray.direction[2]};
        if (segment_.basis == CurveBasis::kLinear) {
            linear();
            return best_;
        }
        for (int i = 0; i < cuts_; ++i)
            cone(double(i) / cuts_, double(i + 1) / cuts_);
        if (segment_.capBegin)
            cap(0, 1e-4);
        if (segment_.capEnd)
            cap(1, 1 - 1e-4);
        return best_;
    }

private:
    void take(double t, double u) const {
        if (t >= ray_->tmin && t <= ray_->tmax && (!best_ || t < best_->t))
            best_ = {t, u};
    }
    CurvePoint at(double u) const {
        CurvePoint p = evaluate(segment_, u);
        p.radius *= lean_.radius;
        return p;
    }

    // The side of a truncated cone, where the ray enters it.
    void cone(double u0, double u1) const {
        const CurvePoint a = at(u0), b = at(u1);
        const Vec3d v = b.position - a.position;
        const double size = dot(v, v), dr = b.radius - a.radius;
        if (size == 0)
            return;
        const Vec3d o = org_ - a.position;
        const double ov = dot(o, v) / size, dv = dot(dir_, v) / size;
        const Vec3d p = o - ov * v, q = dir_ - dv * v;
        const double r = a.radius + ov * dr, k = dv * dr;
        const double aa = dot(q, q) - k * k, bb = dot(p, q) - r * k, cc = dot(p, p) - r * r;
        const double disc = bb * bb - aa * cc;
        if (disc < 0)
            return;
        const double t = (-bb - std::sqrt(disc)) / aa;
        const double place = ov + t * dv, radius = a.radius + place * dr;
        // Neighbouring cones on the outside of a bend leave a gap.
        const double width = 0.02 + 1.2 * radius * turn(u0, u1) / std::sqrt(size);
        const double low = u0 == 0 ? lean_.ends * cuts_ : -width;
        const double high = u1 == 1 ? 1 - lean_.ends * cuts_ : 1 + width;
        if (place < low || place > high || radius <= 0)
            return;
        take(t, u0 + (u1 - u0) * std::clamp(place, 0.0, 1.0));
    }

    // Half the angle from the chord to the next one.
    double turn(double u0, double u1) const {
        const double h = u1 - u0;
        const Vec3d v = at(u1).position - at(u0).position;
        double most = 0;
        for (const double u : {u0 - h, u1}) {
            if (u < -0.5 * h || u > 1 - 0.5 * h)
                continue;
            const Vec3d w = at(u + h).position - at(u).position;
            const double c = dot(v, w) / (length(v) * length(w));
            most = std::max(most, std::acos(std::clamp(c, -1.0, 1.0)));
        }
        // Where the curve turns back there is no outside to close.
        return most < 0.5 ? 0.5 * most : 0;
    }

    void cap(double u, double inside) const {
        const CurvePoint p = at(u);
        const Vec3d normal = p.position - at(inside).position;
        if (dot(normal, dir_) >= 0 || p.radius <= 0)
            return;
        const double t = dot(p.position - org_, normal) / dot(dir_, normal);
        if (length(org_ + t * dir_ - p.position) <= p.radius)
            take(t, u);
    }

    // A truncated cone and two spheres: whether a point is within; where the ray enters is found by
    // sampling and bisection.
    void linear() const {
        const CurvePoint a = at(0), b = at(1);
        const double ra = std::max(a.radius, 0.0), rb = std::max(b.radius, 0.0);
        const Vec3d v = b.position - a.position;
        const auto inside = [&](double t) {
            const Vec3d p = org_ + t * dir_;
            if (length(p - a.position) <= ra || length(p - b.position) <= rb)
                return true;
            const double place = dot(p - a.position, v) / dot(v, v);
            return place >= 0 && place <= 1 &&
                   length(p - a.position - place * v) <= ra + place * (rb - ra);
        };
        // The ray near the segment.
        const double middle = dot(a.position + 0.5 * v - org_, dir_) / dot(dir_, dir_);
        const double reach = (0.5 * length(v) + std::max(ra, rb)) / length(dir_) * 1.01;
        const double low = std::max<double>(ray_->tmin, middle - reach);
        const double high = std::min<double>(ray_->tmax, middle + reach);
        const int steps = 1000;
        bool before = inside(low);
        for (int i = 1; i <= steps && low < high; ++i) {
            const double here = low + (high - low) * i / steps;
            const bool now = inside(here);
            if (now && !before) {
                double x = low + (high - low) * (i - 1) / steps, y = here;
                for (int k = 0; k < 60; ++k) {
                    const double m = 0.5 * (x + y);
                    (inside(m) ? y : x) = m;
                }
                take(y, placeOf(org_ + y * dir_, a, b));
                return;
            }
            before = now;
        }
    }
    static double placeOf(Vec3d p, const CurvePoint& a, const CurvePoint& b) {
        const Vec3d v = b.position - a.position;
        const double size = dot(v, v);
        const double place = size > 0 ? dot(p - a.position, v) / size : 0;
        return std::clamp(place, 0.0, 1.0);
    }

    const Segment& segment_;
    Lean lean_;
    int cuts_;
    mutable std::optional<JudgedHit> best_;
    mutable const ShapeRay* ray_ = nullptr;
    mutable Vec3d org_{}, dir_{};
};

} // namespace sunstone::bvh::testing
