// SPDX-License-Identifier: Apache-2.0
// For tests: a reference for rays against round curves in double precision, directly by the
// definition of the surface: all circles of radius r(u) about C(u), orthogonal to C'(u). A ray
// meets the plane of the circle at u in one point, and that point's distance from C(u), less r(u),
// is a function of u whose zeros are the hits. The judge scans it finely and finds each zero by
// bisection, independently of the kernels' method.
#pragma once

#include "bvh/shapes/curves.h"
#include "bvh/shapes/shapes.h"
#include "bvh/testing/meshes.h"

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
inline CurvePoint operator-(const CurvePoint& a, const CurvePoint& b) {
    return {a.position - b.position, a.radius - b.radius};
}
inline CurvePoint operator*(double s, const CurvePoint& a) {
    return {s * a.position, s * a.radius};
}

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

// The derivative by u, from differences that are exact for polynomials up to the fourth degree.
inline CurvePoint derivative(const Segment& s, double u) {
    constexpr double h = 0.125;
    const CurvePoint near = evaluate(s, u + h) - evaluate(s, u - h);
    const CurvePoint far = evaluate(s, u + 2 * h) - evaluate(s, u - 2 * h);
    return 1 / (12 * h) * (8 * near - far);
}

struct JudgedHit {
    double t, u;
};

// Tolerances of the judge: a scale of radii, and a distance by which ends move inwards.
struct Lean {
    double radius = 1;
    double ends = 0;
};

class CurveJudge {
public:
    explicit CurveJudge(const Segment& segment) : segment_(segment) {
        if (segment.basis == CurveBasis::kLinear)
            return;
        const double begin = -kBeyond, end = 1 + kBeyond;
        addPlace(begin);
        for (int i = 1; i <= kScan; ++i)
            scan(places_.back(), placeAt(begin + (end - begin) * i / kScan));
        for (const Place& p : places_)
            fastest_ = std::max(fastest_, dot(p.change.position, p.change.position));
    }

    std::optional<JudgedHit> nearest(const ShapeRay& ray, Lean lean = {}) const {
        best_.reset();
        lean_ = lean;
        ray_ = &ray;
        org_ = {ray.origin[0], ray.origin[1], ray.origin[2]};
        dir_ = {ray.direction[0], ray.direction[1], ray.direction[2]};
        if (segment_.basis == CurveBasis::kLinear) {
            linear();
            return best_;
        }
        double before = 0, here = excess(places_[0]);
        for (size_t i = 1; i < places_.size(); ++i) {
            const double next = excess(places_[i]);
            if ((here < 0) != (next < 0))
                zero(places_[i - 1].u, places_[i].u);
            else if (i > 1 && (here < 0) == (before < 0) && std::fabs(here) <= std::fabs(before) &&
                     std::fabs(here) <= std::fabs(next))
                twoZeros(places_[i - 2].u, places_[i].u);
            before = here;
            here = next;
        }
        if (segment_.capBegin)
            cap(0, 1e-4);
        if (segment_.capEnd)
            cap(1, 1 - 1e-4);
        return best_;
    }

private:
    // The distance that a tolerance may search beyond the ends, and the least number of steps.
    static constexpr double kBeyond = 2e-3;
    static constexpr int kScan = 512;
    // The most rotation of a step, and the length below which a step is not divided.
    static constexpr double kTurn = 0.02, kShortest = 1e-9;
    // At the turning point of a straight line, only rounding changes the direction. Parts slower
    // than this, relative to the fastest part, are skipped.
    static constexpr double kStill = 1e-5;

    struct Place {
        double u;
        CurvePoint at, change;
    };

    Place placeAt(double u) const { return {u, evaluate(segment_, u), derivative(segment_, u)}; }
    void addPlace(double u) { places_.push_back(placeAt(u)); }

    // Adds places up to `to` so that the direction turns little from one to the next.
    void scan(Place from, const Place& to) {
        const Vec3d a = from.change.position, b = to.change.position;
        if (to.u - from.u > kShortest && !(dot(a, b) >= std::cos(kTurn) * length(a) * length(b))) {
            const Place middle = placeAt(0.5 * (from.u + to.u));
            scan(from, middle);
            scan(middle, to);
        } else {
            places_.push_back(to);
        }
    }

    void take(double t, double u) const {
        if (t >= ray_->tmin && t <= ray_->tmax && (!best_ || t < best_->t))
            best_ = {t, u};
    }

    // The excess of the squared distance from C(u) over the squared radius where the ray meets the
    // plane at u, times the square of a cosine, so that it is finite.
    double excess(const Place& p) const {
        const Vec3d w = p.at.position - org_, c = p.change.position;
        const double wc = dot(w, c), dc = dot(dir_, c), size = dot(c, c);
        const double r = p.at.radius * lean_.radius;
        return size == 0 ? 0
                         : (wc * (wc * dot(dir_, dir_) - 2 * dc * dot(w, dir_)) +
                            dc * dc * (dot(w, w) - r * r)) /
                               size;
    }
    double excess(double u) const { return excess(placeAt(u)); }

    void zero(double low, double high) const {
        const bool negative = excess(low) < 0;
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (low + high);
            ((excess(middle) < 0) == negative ? low : high) = middle;
        }
        hit(0.5 * (low + high));
    }

    // Between places of one sign and least magnitude within there may be two zeros.
    void twoZeros(double low, double high) const {
        const double begin = low, end = high, sign = excess(low) < 0 ? -1 : 1;
        for (int i = 0; i < 80; ++i) {
            const double a = low + (high - low) * 0.382, b = low + (high - low) * 0.618;
            const double atA = sign * excess(a), atB = sign * excess(b);
            if (atA < 0 || atB < 0) {
                zero(begin, atA < 0 ? a : b);
                zero(atA < 0 ? a : b, end);
                return;
            }
            (atA < atB ? high : low) = atA < atB ? b : a;
        }
    }

    // Counts a hit if the ray enters the cone around the circle. Next to a cusp the function may
    // change its sign without a zero.
    void hit(double u) const {
        const Place p = placeAt(u);
        const Vec3d c = p.change.position;
        const double along = dot(dir_, c), size = dot(c, c), r = p.at.radius * lean_.radius;
        if (u < lean_.ends || u > 1 - lean_.ends || r <= 0 || size <= kStill * kStill * fastest_ ||
            std::fabs(along) <= 1e-9 * std::sqrt(size * dot(dir_, dir_)))
            return;
        const double t = dot(p.at.position - org_, c) / along;
        const Vec3d outwards = org_ + t * dir_ - p.at.position;
        if (std::fabs(length(outwards) - r) <= 1e-5 * r &&
            dot(outwards, dir_) < r * p.change.radius * lean_.radius * along / size)
            take(t, u);
    }

    void cap(double u, double inside) const {
        const CurvePoint p = evaluate(segment_, u);
        const Vec3d normal = p.position - evaluate(segment_, inside).position;
        if (dot(normal, dir_) >= 0 || p.radius <= 0)
            return;
        const double t = dot(p.position - org_, normal) / dot(dir_, normal);
        if (length(org_ + t * dir_ - p.position) <= p.radius * lean_.radius)
            take(t, u);
    }

    // A truncated cone and two spheres: whether a point is within; where the ray enters is found by
    // sampling and bisection.
    void linear() const {
        const CurvePoint a = evaluate(segment_, 0), b = evaluate(segment_, 1);
        const double ra = std::max(a.radius * lean_.radius, 0.0),
                     rb = std::max(b.radius * lean_.radius, 0.0);
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

    const Segment segment_;
    std::vector<Place> places_; // where the function is looked at
    double fastest_ = 0;        // square of the largest derivative
    mutable Lean lean_;
    mutable std::optional<JudgedHit> best_;
    mutable const ShapeRay* ray_ = nullptr;
    mutable Vec3d org_{}, dir_{};
};

} // namespace sunstone::bvh::testing
