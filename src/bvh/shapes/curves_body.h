// SPDX-License-Identifier: Apache-2.0
// Rays against round curves, compiled once per instruction set.
//
// All computations are in the space of the ray (ray_space.h). First, the capsules of a leaf's
// pieces are tested together: the ray meets a capsule if its chord is nearer to the z axis than its
// radius. The remaining pieces:
//
// Linear segments (same pass): the union of a truncated cone and two spheres. Each of the three is
// convex and covers an interval of the ray; a hit is the start of an interval outside the other
// two. Rays that start inside therefore hit no surface from within.
//
// Other bases, one piece at a time: eight lanes (N at a time; on GPUs one after the other) start in
// the middle of the piece's eighths and iterate. About C(u), the surface is nearly the cone with
// axis C'(u) and radius r(u) + r'(u) du; the ray enters it at a distance found by a quadratic
// equation, and the distance of that point from the plane orthogonal to the curve at u gives the
// next u:
//     du = q.C' / (C'.C' - q.C''),   q = hit - C(u)   (C'' here without its part along C')
// The denominator has the curvature, so that convergence is fast while the radius of curvature
// exceeds r. (The idea of cones along the curve is from Reshetov and Luebke, "Phantom Ray-Hair
// Intersector", 2018.) Distances are relative to C(u), so that no large terms cancel. A lane's
// result counts if the iteration has converged within its eighth. Pieces whose direction changes
// much within an eighth, or whose radius of curvature is below their radius, are cut further and
// searched more carefully (settleBent).
//
// Only surfaces that the ray enters are hit: curves are hollow and invisible from within.
#pragma once

#include "bvh/shapes/curves.h"
#include "bvh/walk/ray_space.h"

namespace sunstone::bvh::SUNSTONE_ISA {

#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpsabi"

// Parameters of hits on the side are strictly between 0 and 1, because 0 and 1 stand for caps.
constexpr float kFirstU = 0x1p-24f, kLastU = 1 - 0x1p-24f;

SUNSTONE_INLINE float insideU(float u) {
    return u > kFirstU ? (u < kLastU ? u : kLastU) : kFirstU;
}

// The position polynomial of a segment in ray space, all lanes alike: x, y, z, radius.
template <unsigned N>
struct CurveLanes {
    using V = Lanes<N>;
    V a[4][4]; // [power][component]
    V4 power[4];

    SUNSTONE_INLINE_MEMBER CurveLanes(const RaySpace& s, const float* points, CurveBasis basis) {
        const auto& weights = powerWeights<float>(basis);
        const uint32_t degree = degreeOf(basis);
        V4 p[4];
        for (uint32_t i = 0; i < 4; ++i)
            p[i] = i <= degree ? toRaySpace(s, loadLanes<V4>(points + 4 * i)) : V4{};
        for (int k = 0; k < 4; ++k) {
            power[k] = weights[k][0] * p[0];
            for (int i = 1; i < 4; ++i)
                power[k] = fused(all<V4>(weights[k][i]), p[i], power[k]);
            for (int c = 0; c < 4; ++c)
                a[k][c] = all<V>(power[k][c]);
        }
    }
    SUNSTONE_INLINE_MEMBER V value(int c, V u) const {
        return fused(fused(fused(a[3][c], u, a[2][c]), u, a[1][c]), u, a[0][c]);
    }
    SUNSTONE_INLINE_MEMBER V first(int c, V u) const {
        return fused(fused(3 * a[3][c], u, 2 * a[2][c]), u, a[1][c]);
    }
    SUNSTONE_INLINE_MEMBER V second(int c, V u) const {
        return fused(6 * a[3][c], u, 2 * a[2][c]);
    }
    SUNSTONE_INLINE_MEMBER V4 value(float u) const {
        return ((power[3] * u + power[2]) * u + power[1]) * u + power[0];
    }
    // Direction at an end, also where the first derivative is zero.
    SUNSTONE_INLINE_MEMBER V4 direction(float u) const {
        V4 d = (3 * power[3] * u + 2 * power[2]) * u + power[1];
        const V4 next = 6 * power[3] * u + 2 * power[2];
        const float sign = u > 0 ? -1.0f : 1.0f; // towards the inside of the segment
        const auto size = [](V4 v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
        const float scale = size(power[1]) + size(power[2]) + size(power[3]);
        if (!(size(d) > 1e-10f * scale))
            d = sign * next;
        if (!(size(d) > 1e-10f * scale))
            d = power[3];
        return d;
    }
};

struct CurveCandidate {
    float t, u;
};

// For each lane, the parameter in its part of the segment at which it has converged.
template <unsigned N>
struct SettledLanes {
    Lanes<N> t, u;
    Mask mask;
};

// The eighths of the lanes, from `first` on.
template <unsigned N>
SUNSTONE_INLINE Lanes<N> eighths(uint32_t first) {
    if constexpr (N == 8)
        return V8{0, 1, 2, 3, 4, 5, 6, 7};
    else
        return all<V1>(float(first));
}

// The points where the ray enters the cones around C(u): at the distance q behind the depth of
// C(u), and by m in front of the plane at u, in units of |C'|.
template <unsigned N>
struct ConeEntries {
    Lanes<N> q, m, speed, bend, radius, discriminant;
};
template <unsigned N>
SUNSTONE_INLINE ConeEntries<N> enterCones(const CurveLanes<N>& curve, Lanes<N> u) {
    using V = Lanes<N>;
    ConeEntries<N> e;
    const V x = curve.value(0, u), y = curve.value(1, u), r = curve.value(3, u);
    const V dx = curve.first(0, u), dy = curve.first(1, u), dz = curve.first(2, u),
             dr = curve.first(3, u);
    const V flat = fused(dx, dx, dy * dy);
    e.speed = fused(dz, dz, flat);
    const V inverse = 1 / e.speed;
    const V cross = x * dy - y * dx, distance = fused(x, x, y * y);
    const V along = -fused(x, dx, y * dy); // (q . C') for q at the depth of C(u)
    // Cone: a z^2 + 2 b z + c = 0 for z from C(u) on.
    const V slope = dr * inverse, rAlong = fused(slope, along, r);
    const V a = inverse * fused(-dr * slope, dz * dz, flat);
    const V b = -dz * fused(along, inverse, slope * rAlong);
    const V c = fused(inverse, fused(dz * dz, distance, cross * cross), -rAlong * rAlong);
    e.discriminant = fused(b, b, -a * c);
    const V root = rootOrZero(e.discriminant);
    const auto growing = b > 0;
    e.q = (growing ? -b - root : c) / (growing ? a : root - b);
    e.m = fused(e.q, dz, along);
    // q.C'' without the part along the curve, which affects only the parameter's speed.
    const V ddx = curve.second(0, u), ddy = curve.second(1, u), ddz = curve.second(2, u);
    const V hurry = fused(dx, ddx, fused(dy, ddy, dz * ddz)) * inverse;
    e.bend = fused(e.q, ddz, -fused(x, ddx, fused(y, ddy, e.m * hurry)));
    e.radius = fused(dr * inverse, e.m, r);
    return e;
}

// The converged lanes: one more step of du would hardly change them.
template <unsigned N>
SUNSTONE_INLINE SettledLanes<N> settledLanes(const CurveLanes<N>& curve, const RaySpace& s,
                                             const ConeEntries<N>& e, Lanes<N> u, Lanes<N> du,
                                             Lanes<N> middle, float h, float tmax) {
    SettledLanes<N> out;
    out.u = u + du;
    out.t = (curve.value(2, u) + e.q) * s.toT;
    const auto good = (e.discriminant >= 0.0f) & (e.radius > 0.0f) & (magnitude(du) <= 0.05f * h) &
                      (magnitude(out.u - middle) <= 0.502f * h) & (out.t >= s.tmin) &
                      (out.t <= tmax) &
                      // Shorter lengths are lost in rounding.
                      (e.speed * (h * h) > 1e-12f * e.radius * e.radius);
    out.mask = bitsOfMask(good);
    return out;
}

// Lanes over the eighths of [begin, begin + length], from `first` on.
template <unsigned N, int kSteps>
SUNSTONE_INLINE SettledLanes<N> settle(const CurveLanes<N>& curve, const RaySpace& s, float begin,
                                       float length, uint32_t first, float tmax) {
    using V = Lanes<N>;
    const float h = length / 8;
    const V middle = begin + h * (eighths<N>(first) + 0.5f);
    V u = middle;
    for (int step = 1;; ++step) {
        const ConeEntries<N> e = enterCones<N>(curve, u);
        const V du = e.m / mostOf(e.speed - e.bend, 0.2f * e.speed);
        if (step == kSteps)
            return settledLanes<N>(curve, s, e, u, du, middle, h, tmax);
        u = leastOf(mostOf(u + du, middle - h), middle + h);
    }
}

// As settle(), for curves whose radius of curvature may be below their radius. There m may rise as
// well as fall, and the entry of a grazing ray moves faster than the steps predict. Each lane
// therefore evaluates both ends of its part first. After m has had both signs, a lane keeps the
// last place of each sign and stays between them: every other step goes to the zero of the straight
// line through the two.
constexpr int kBentSteps = 12;
template <unsigned N>
[[gnu::noinline]] static SettledLanes<N> settleBent(const CurveLanes<N>& curve, const RaySpace& s,
                                                    float begin, float length, uint32_t first,
                                                    float tmax) {
    using V = Lanes<N>;
    const float h = length / 8;
    const V middle = begin + h * (eighths<N>(first) + 0.5f), none = all<V>(__builtin_nanf(""));
    V u = middle - 0.5f * h, above = none, below = none, mAbove = none, mBelow = none;
    for (int step = 1;; ++step) {
        const ConeEntries<N> e = enterCones<N>(curve, u);
        const auto positive = e.m >= 0.0f;
        above = positive ? u : above;
        below = positive ? below : u;
        mAbove = positive ? e.m : mAbove;
        mBelow = positive ? mBelow : e.m;
        if (step == 1) {
            u = middle + 0.5f * h;
            continue;
        }
        const V slope = e.speed - e.bend, least = 0.2f * e.speed;
        const V du = e.m / (slope < 0.0f ? leastOf(slope, -least) : mostOf(slope, least));
        if (step == kBentSteps) {
            const V most = all<V>(0.05f * h), last = leastOf(mostOf(du, -most), most);
            SettledLanes<N> lanes = settledLanes<N>(curve, s, e, u, last, middle, h, tmax);
            // A jump of m changes its sign, but is no hit.
            const V near = 1e-3f * e.radius;
            lanes.mask &= bitsOfMask(e.m * e.m <= near * near * e.speed);
            return lanes;
        }
        const auto both = (above == above) & (below == below);
        const V low = leastOf(above, below), high = mostOf(above, below), next = u + du;
        const auto fits = ((next > low) & (next < high)) | (magnitude(du) <= 1e-3f * h);
        const V straight = (above * mBelow - below * mAbove) / (mBelow - mAbove);
        const V inside = step & 1 ? (fits ? next : 0.5f * (low + high)) : straight;
        const V alone = step == 2 ? middle : leastOf(mostOf(next, middle - h), middle + h);
        u = both ? inside : alone;
    }
}

// The eighths that must be cut because their direction changes by more than 14 degrees. The
// direction changes by at most the sum of the angles between consecutive Bernstein coefficients of
// the derivative, which are 7 degrees each here.
template <unsigned N>
SUNSTONE_INLINE Mask turnsMuch(const CurveLanes<N>& curve, Lanes<N> u0, Lanes<N> u1, float h) {
    using V = Lanes<N>;
    constexpr float kCosineSquared = 0.985f;
    V d[3][3], size[3] = {};
    for (int c = 0; c < 3; ++c) {
        d[0][c] = curve.first(c, u0);
        d[1][c] = fused(curve.second(c, u0), all<V>(0.5f * h), d[0][c]);
        d[2][c] = curve.first(c, u1);
        for (int k = 0; k < 3; ++k)
            size[k] = fused(d[k][c], d[k][c], size[k]);
    }
    const auto turns = [&](int k) {
        const V along =
            fused(d[k][0], d[k + 1][0], fused(d[k][1], d[k + 1][1], d[k][2] * d[k + 1][2]));
        return (along <= 0.0f) | (along * along < kCosineSquared * (size[k] * size[k + 1]));
    };
    return bitsOfMask(turns(0) | turns(1));
}

// The eighths that the ray may meet, those that must be cut because their direction changes much,
// and those that need more than settle(), because the radius is not small compared with the radius
// of curvature or the parameter's speed changes much.
struct EighthTest {
    Mask meets, bent, tight;
};
template <unsigned N>
SUNSTONE_INLINE EighthTest testLanes(const CurveLanes<N>& curve, const RaySpace& s, float begin,
                                     float length, uint32_t first, float tmax) {
    using V = Lanes<N>;
    const float h = length / 8;
    const V u0 = begin + h * eighths<N>(first), u1 = u0 + h;
    const V ax = curve.value(0, u0), ay = curve.value(1, u0), az = curve.value(2, u0);
    const V vx = curve.value(0, u1) - ax, vy = curve.value(1, u1) - ay,
             vz = curve.value(2, u1) - az;
    // Bounds of the deviation of the curve and its radius from linear.
    V off = {}, offR = {};
    const V ends[2] = {u0, u1};
    auto tight = u0 > u1;
    for (const V u : ends) {
        const V x = curve.second(0, u), y = curve.second(1, u), z = curve.second(2, u);
        const V dx = curve.first(0, u), dy = curve.first(1, u), dz = curve.first(2, u);
        const V size = x * x + y * y + z * z, speed = dx * dx + dy * dy + dz * dz,
                 along = x * dx + y * dy + z * dz, r = curve.value(3, u);
        off = mostOf(off, size);
        offR = mostOf(offR, magnitude(curve.second(3, u)));
        tight |= ((size * speed - along * along) * r * r > 0.0625f * speed * speed * speed) |
                 (magnitude(along) * h > speed);
    }
    const V flat = vx * vx + vy * vy;
    const V place =
        leastOf(mostOf(-(ax * vx + ay * vy) / mostOf(flat, all<V>(1e-37f)), V{}), all<V>(1));
    const V px = fused(place, vx, ax), py = fused(place, vy, ay);
    const V r = mostOf(magnitude(curve.value(3, u0)), magnitude(curve.value(3, u1))) +
                 (rootOf(off) + offR) * (h * h / 8) + 0x1p-20f * (magnitude(az) + magnitude(vz));
    const V low = leastOf(az, az + vz) - r, high = mostOf(az, az + vz) + r;
    const auto meets =
        (px * px + py * py <= r * r) & (low <= tmax * s.length) & (high >= s.tmin * s.length);
    return {bitsOfMask(meets), turnsMuch<N>(curve, u0, u1, h), bitsOfMask(tight)};
}

// Circles around the centres of the eighths, in projection along the ray. Each circle encloses its
// eighth. For one lane they are a first test before testLanes(), which needs five times as many
// operations.
struct EighthCircles {
    float reach; // of the curve and of its radius' change from the middle

    SUNSTONE_INLINE_MEMBER EighthCircles(const CurveLanes<1>& curve, float begin, float length) {
        // The derivative's Bernstein coefficients bound the speed.
        const V1 u0 = all<V1>(begin), u1 = all<V1>(begin + length);
        float most = 0, mostR = 0, depth = 0;
        V1 d[3][4];
        for (int c = 0; c < 4; ++c) {
            d[0][c] = curve.first(c, u0);
            d[1][c] = fused(curve.second(c, u0), all<V1>(0.5f * length), d[0][c]);
            d[2][c] = curve.first(c, u1);
        }
        for (const auto& each : d) {
            most = larger(most, each[0][0] * each[0][0] + each[1][0] * each[1][0]);
            mostR = larger(mostR, magnitude(each[3])[0]);
        }
        for (int k = 0; k < 4; ++k)
            depth += magnitude(curve.a[k][2])[0];
        reach =
            (rootOf(all<V1>(most))[0] + mostR) * (length / 16) * (1 + 0x1p-16f) + 0x1p-18f * depth;
    }
    // Whether the ray meets the circle around the curve at u.
    SUNSTONE_INLINE_MEMBER bool meets(const CurveLanes<1>& curve, float u) const {
        const V1 at = all<V1>(u), x = curve.value(0, at), y = curve.value(1, at);
        const float r = magnitude(curve.value(3, at))[0] + reach;
        return !(x[0] * x[0] + y[0] * y[0] > r * r);
    }
    static SUNSTONE_INLINE_MEMBER float larger(float a, float b) { return a > b ? a : b; }
};

template <unsigned N>
SUNSTONE_INLINE EighthTest testEighths(const CurveLanes<N>& curve, const RaySpace& s, float begin,
                                       float length, float tmax) {
    EighthTest all = {};
    if constexpr (N == 1) {
        const EighthCircles circles(curve, begin, length);
        Mask near = 0;
        for (uint32_t i = 0; i < 8; ++i)
            if (circles.meets(curve, begin + length * (float(i) + 0.5f) / 8))
                near |= 1u << i;
        for (Mask m = near; m; m &= m - 1) {
            const uint32_t first = lowestBit(m);
            const EighthTest some = testLanes<1>(curve, s, begin, length, first, tmax);
            all.meets |= some.meets << first;
            all.bent |= some.bent << first;
            all.tight |= some.tight << first;
        }
        return all;
    }
    for (uint32_t first = 0; first < 8; first += N) {
        const EighthTest some = testLanes<N>(curve, s, begin, length, first, tmax);
        all.meets |= some.meets << first;
        all.bent |= some.bent << first;
        all.tight |= some.tight << first;
    }
    return all;
}

template <unsigned N>
SUNSTONE_INLINE bool takeNearest(const SettledLanes<N>& lanes, CurveCandidate& best) {
    alignas(32) float t[N], u[N];
    __builtin_memcpy(t, &lanes.t, sizeof t);
    __builtin_memcpy(u, &lanes.u, sizeof u);
    bool found = false;
    for (Mask m = lanes.mask; m; m &= m - 1) {
        const unsigned i = lowestBit(m);
        if (t[i] > best.t)
            continue;
        best = {t[i], insideU(u[i])};
        found = true;
    }
    return found;
}

// Runs the iteration for these eighths: all together, or one after the other.
template <unsigned N, class Settle>
SUNSTONE_INLINE bool settleEighths(Mask where, CurveCandidate& best, const Settle& settled) {
    bool found = false;
    if constexpr (N == 8) {
        SettledLanes<8> lanes = settled(0);
        lanes.mask &= where;
        found = takeNearest<8>(lanes, best);
    } else {
        for (Mask m = where; m; m &= m - 1)
            found |= takeNearest<N>(settled(lowestBit(m)), best);
    }
    return found;
}
template <unsigned N>
SUNSTONE_INLINE bool settleStraight(const CurveLanes<N>& curve, const RaySpace& s, float begin,
                                    float length, Mask where, CurveCandidate& best) {
    return settleEighths<N>(where, best, [&](uint32_t first) {
        return settle<N, 3>(curve, s, begin, length, first, best.t);
    });
}

// Levels of cutting into eighths. Together with the splits into pieces, these suffice for curves
// with cusps.
constexpr int kBentLevels = 3;

// Cuts bent pieces; at the last level takes them as they are.
template <unsigned N>
[[gnu::noinline]] static bool intersectBent(const CurveLanes<N>& curve, const RaySpace& s,
                                            float begin, float length, CurveCandidate& best) {
    struct Part {
        float begin;
        Mask bent; // eighths that are still to be cut
    } parts[kBentLevels];
    bool found = false;
    for (int level = 0;;) {
        const EighthTest test = testEighths<N>(curve, s, begin, length, best.t);
        const Mask cut = level < kBentLevels ? test.meets & test.bent : 0;
        if (test.meets & (test.bent | test.tight))
            found |= settleEighths<N>(test.meets & ~cut, best, [&](uint32_t first) {
                return settleBent<N>(curve, s, begin, length, first, best.t);
            });
        else if (test.meets)
            found |= settleStraight<N>(curve, s, begin, length, test.meets, best);
        if (cut) {
            parts[level++] = {begin, cut};
            length /= 8;
        }
        while (level > 0 && !parts[level - 1].bent) {
            --level;
            length *= 8;
        }
        if (level == 0)
            return found;
        Part& part = parts[level - 1];
        begin = part.begin + float(lowestBit(part.bent)) * length;
        part.bent &= part.bent - 1;
    }
}

// The disc that closes an end.
template <unsigned N>
SUNSTONE_INLINE bool intersectCap(const CurveLanes<N>& curve, const RaySpace& s, float u,
                                  CurveCandidate& best) {
    const V4 p = curve.value(u), d = curve.direction(u);
    // The outside of a disc is against the curve's direction at its beginning, along it at its end.
    if (!(u > 0 ? d[2] < 0 : d[2] > 0) || !(p[3] > 0))
        return false;
    const float q = (p[0] * d[0] + p[1] * d[1]) / d[2];
    const float t = (p[2] + q) * s.toT;
    if (!(p[0] * p[0] + p[1] * p[1] + q * q <= p[3] * p[3]) || !(t >= s.tmin && t <= best.t))
        return false;
    best = {t, u};
    return true;
}

// The nearest hit of a piece that is not behind best.t.
template <unsigned N>
SUNSTONE_INLINE bool intersectPiece(const RaySpace& s, const float* points, CurveBasis basis,
                                    uint32_t word, uint32_t flags, CurveCandidate& best) {
    const CurveLanes<N> curve(s, points, basis);
    const PieceRange range = rangeOf(word);
    bool found;
    if (__builtin_expect(flags & kCurveBent, 0)) {
        found = intersectBent<N>(curve, s, range.begin, range.length, best);
    } else {
        // If eighths run one after the other, skipping parts that the ray cannot meet saves time.
        Mask where = 0xFF;
        if constexpr (N < 8)
            where = testEighths<N>(curve, s, range.begin, range.length, best.t).meets;
        found = settleStraight<N>(curve, s, range.begin, range.length, where, best);
    }
    if (__builtin_expect((flags & kCurveCapBegin) && range.begin == 0, 0))
        found |= intersectCap(curve, s, 0, best);
    if (__builtin_expect((flags & kCurveCapEnd) && range.begin + range.length == 1, 0))
        found |= intersectCap(curve, s, 1, best);
    return found;
}

// The pieces of a leaf whose capsules the ray meets, and the z of entry.
template <unsigned N>
SUNSTONE_INLINE Mask testCapsules(const float* rows, const RaySpace& s, float tmax,
                                  Lanes<N>& near) {
    using V = Lanes<N>;
    const auto row = [&](int i) { return loadLanes<V>(rows + i * int(N)); };
    const Point<V> a = toRaySpace(s, row(0), row(1), row(2));
    const Point<V> b = toRaySpace(s, row(3), row(4), row(5));
    const V vx = b.x - a.x, vy = b.y - a.y;
    const V flat = mostOf(fused(vx, vx, vy * vy), all<V>(1e-37f));
    const V place = leastOf(mostOf(-fused(a.x, vx, a.y * vy) / flat, V{}), all<V>(1));
    const V px = fused(place, vx, a.x), py = fused(place, vy, a.y);
    const V r = row(6) + 0x1p-20f * (magnitude(a.z) + magnitude(b.z));
    near = leastOf(a.z, b.z) - r;
    return bitsOfMask((fused(px, px, py * py) <= r * r) & (near <= tmax * s.length) &
                      (mostOf(a.z, b.z) + r >= s.tmin * s.length));
}

// Linear segments of a leaf: the nearest entry of each, at tmin or behind.
template <unsigned N>
SUNSTONE_INLINE Mask testCones(const float* rows, const RaySpace& s, float tmax, Lanes<N>& t,
                               Lanes<N>& u) {
    using V = Lanes<N>;
    const auto row = [&](int i) { return loadLanes<V>(rows + i * int(N)); };
    const Point<V> a = toRaySpace(s, row(0), row(1), row(2));
    const Point<V> b = toRaySpace(s, row(3), row(4), row(5));
    const V ra = row(6), rb = row(7);
    const V dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z, dr = rb - ra;
    const V flat = fused(dx, dx, dy * dy), tiny = all<V>(1e-37f);
    const V place = leastOf(mostOf(-fused(a.x, dx, a.y * dy) / mostOf(flat, tiny), V{}), all<V>(1));
    const V x = fused(place, dx, a.x), y = fused(place, dy, a.y), z = fused(place, dz, a.z);
    const V distance = fused(x, x, y * y);
    const V margin = mostOf(ra, rb);
    if (bitsOfMask(distance <= margin * margin * (1 + 0x1p-20f)) == 0)
        return 0;
    const V far = all<V>(__builtin_inff());
    // Spheres.
    const auto half = [&](const Point<V>& p, V r, V& root) {
        const V square = fused(r, r, -fused(p.x, p.x, p.y * p.y));
        root = rootOrZero(square);
        return square >= 0.0f;
    };
    V rootA, rootB;
    const auto meetsA = half(a, ra, rootA), meetsB = half(b, rb, rootB);
    const V inA = meetsA ? a.z - rootA : far, outA = meetsA ? a.z + rootA : -far;
    const V inB = meetsB ? b.z - rootB : far, outB = meetsB ? b.z + rootB : -far;
    // Cone about the axis, z from the point nearest to the ray on; see settle().
    const V speed = fused(dz, dz, flat), inverse = 1 / speed;
    const V cross = x * dy - y * dx, along = -fused(x, dx, y * dy), slope = dr * inverse;
    const V r = fused(place, dr, ra), rAlong = fused(slope, along, r);
    const V ca = inverse * fused(-dr * slope, dz * dz, flat);
    const V cb = -dz * fused(along, inverse, slope * rAlong);
    const V cc = fused(inverse, fused(dz * dz, distance, cross * cross), -rAlong * rAlong);
    const V discriminant = fused(cb, cb, -ca * cc), root = rootOrZero(discriminant);
    const auto positive = cb > 0.0f;
    const V q1 = positive ? (-cb - root) / ca : cc / (root - cb);
    const V q2 = positive ? cc / (-cb - root) : (root - cb) / ca;
    // Between the planes at the ends.
    const V perZ = 1 / dz;
    const V toBegin = -fused(place, speed, along) * perZ,
            toEnd = fused(1 - place, speed, -along) * perZ;
    const auto across = magnitude(dz) <= 1e-18f;
    const V level = fused(place, speed, along); // where the ray is along the axis, at z
    const auto beside = across & ((level < 0.0f) | (level > speed));
    const V slabIn = across ? (beside ? far : -far) : leastOf(toBegin, toEnd);
    const V slabOut = across ? (beside ? -far : far) : mostOf(toBegin, toEnd);
    // If the ray is steeper than the cone, it is inside from one root on, or up to one root.
    const auto steep = ca <= 0.0f, growing = dz * dr > 0.0f;
    const auto none = discriminant < 0.0f;
    // A cylinder along the ray has no roots: the whole ray is inside, or none of it.
    const auto rootless = none | ((ca == 0.0f) & (cb == 0.0f));
    const V first = steep ? (growing & ~rootless ? q1 : -far) : q1;
    const V last = steep ? (growing | rootless ? far : q2) : q2;
    const auto meetsC = (steep ? (~rootless | none | (cc <= 0.0f)) : ~none) & (speed > 0.0f) &
                        (mostOf(first, slabIn) <= leastOf(last, slabOut));
    const V inC = meetsC ? z + mostOf(first, slabIn) : far,
            outC = meetsC ? z + leastOf(last, slabOut) : -far;
    const auto side = meetsC & (first >= slabIn);
    // Entries that are outside the other parts.
    const V zmin = all<V>(s.tmin * s.length);
    const auto within = [](V at, V in, V out) { return (in < at) & (at < out); };
    const auto goodA = meetsA & (inA >= zmin) & ~within(inA, inB, outB) & ~within(inA, inC, outC);
    const auto goodB = meetsB & (inB >= zmin) & ~within(inB, inA, outA) & ~within(inB, inC, outC);
    const auto goodC = side & (inC >= zmin) & ~within(inC, inA, outA) & ~within(inC, inB, outB);
    V best = goodA ? inA : far;
    u = V{};
    const auto takesB = goodB & (inB < best);
    best = takesB ? inB : best;
    u = takesB ? all<V>(1) : u;
    const auto takesC = goodC & (inC <= best);
    const V onSide = fused(fused(first, dz, along), inverse, place);
    best = takesC ? inC : best;
    u = takesC ? leastOf(mostOf(onSide, all<V>(kFirstU)), all<V>(kLastU)) : u;
    t = best * s.toT;
    return bitsOfMask((goodA | goodB | goodC) & (t >= s.tmin) & (t <= tmax));
}

#pragma clang diagnostic pop

} // namespace sunstone::bvh::SUNSTONE_ISA
