// SPDX-License-Identifier: Apache-2.0
// The watertight ray/triangle test on 4 or 8 triangles. Included through traverse.h.
//
// Vertices are moved to the ray origin and sheared so that the ray becomes the z axis; a vertex
// gets equal coordinates in all its triangles. The 2D edge functions are differences of two
// products, computed without FMA: rounding is monotone, so the sign of a non-zero difference is
// right, and a triangle and its neighbour get exactly negated values on their common edge. Zero may
// stand for either sign, so lanes with a zero edge are computed again in double precision, where
// products of floats are exact. A value that is still zero counts as inside for both neighbours: a
// ray through an edge or vertex hits at least one of the triangles there. Slivers are computed
// again, too: if the area is far smaller than the products, the rounding of the products would
// affect t, u and v. Both computations agree on the signs, so neighbours may use different ones.
//
// No operation depends on the instruction set, so all sets report equal t, u and v.
#pragma once

#include "bvh/walk/ray_setup.h"

namespace sunstone::bvh::SUNSTONE_ISA {

// The ratio of products to the area above which the rounding of the products matters.
constexpr float kSliver = 128;

// Edge functions of the lanes: u belongs to vertex 0, v to vertex 1, w to vertex 2.
template <unsigned N>
struct alignas(64) TriangleCandidates {
    float t[N], v[N], w[N], det[N];
};

// Ray values in all lanes.
template <class F>
struct ShearLanes {
    F ox, oy, oz, sx, sy, sz;
};

template <class F>
SUNSTONE_INLINE ShearLanes<F> shearLanes(const RaySetup& s) {
    F* const f = nullptr;
    return {splat(s.org[s.axis[0]], f),   splat(s.org[s.axis[1]], f),   splat(s.org[s.axis[2]], f),
            splat(s.slope[s.axis[0]], f), splat(s.slope[s.axis[1]], f), splat(s.slope[3], f)};
}

// Recomputes the edge functions of one lane exactly.
template <unsigned N>
[[gnu::noinline, gnu::cold]] static void refineLane(unsigned lane, const float (&x)[3][N],
                                                    const float (&y)[3][N], float (&edge)[3][N]) {
    for (int i = 0; i < 3; ++i) {
        const int b = i == 2 ? 0 : i + 1, c = b == 2 ? 0 : b + 1;
        edge[i][lane] = float(double(x[c][lane]) * double(y[b][lane]) -
                              double(y[c][lane]) * double(x[b][lane]));
    }
}

// One coordinate of one vertex of all triangles in a leaf.
template <unsigned N, class F>
SUNSTONE_INLINE F vertexLanes(const TriangleLeaf<N>& leaf, uint32_t vertex, uint32_t axis, F* f) {
    return load(leaf.vertices + (3 * vertex + axis) * N, f);
}

// Lanes whose triangle is hit at tmin <= t <= tmax; their values are in `out`. axes: kx, ky, kz.
// Leaf: a type with an overload of vertexLanes. Lanes are triangles, rays, or both.
template <unsigned N, class F, class Leaf>
SUNSTONE_INLINE Mask testTriangles(const Leaf& leaf, const uint32_t* axes, const ShearLanes<F>& r,
                                   F tmin, F tmax, TriangleCandidates<N>& out) {
    F* const f = nullptr;
    const uint32_t kx = axes[0], ky = axes[1], kz = axes[2];
    const F az = vertexLanes(leaf, 0, kz, f) - r.oz, bz = vertexLanes(leaf, 1, kz, f) - r.oz,
            cz = vertexLanes(leaf, 2, kz, f) - r.oz;
    const F ax = (vertexLanes(leaf, 0, kx, f) - r.ox) - r.sx * az,
            ay = (vertexLanes(leaf, 0, ky, f) - r.oy) - r.sy * az;
    const F bx = (vertexLanes(leaf, 1, kx, f) - r.ox) - r.sx * bz,
            by = (vertexLanes(leaf, 1, ky, f) - r.oy) - r.sy * bz;
    const F cx = (vertexLanes(leaf, 2, kx, f) - r.ox) - r.sx * cz,
            cy = (vertexLanes(leaf, 2, ky, f) - r.oy) - r.sy * cz;
    const F u0 = cx * by, u1 = cy * bx, v0 = ax * cy, v1 = ay * cx, w0 = bx * ay, w1 = by * ax;
    F u = u0 - u1, v = v0 - v1, w = w0 - w1;
    const F zero = splat(0.0f, f);
    const F least = min(min(u, v), w), most = max(max(u, v), w);
    Mask inside = lessEqual(zero, least) | lessEqual(most, zero);
    if (__builtin_expect(inside == 0, 1))
        return 0;
    const auto magnitude = [&](F x) { return max(x, zero - x); };
    const F products = max(max(magnitude(u0) + magnitude(u1), magnitude(v0) + magnitude(v1)), //
                           magnitude(w0) + magnitude(w1));
    const F area = magnitude((u + v) + w);
    const Mask rough = (equal(u, zero) | equal(v, zero) | equal(w, zero) |
                        lessEqual(area * splat(kSliver, f), products)) &
                       inside;
    if (__builtin_expect(rough != 0, 0)) {
        alignas(64) float x[3][N], y[3][N], edge[3][N];
        store(x[0], ax), store(x[1], bx), store(x[2], cx);
        store(y[0], ay), store(y[1], by), store(y[2], cy);
        store(edge[0], u), store(edge[1], v), store(edge[2], w);
        for (Mask m = rough; m; m &= m - 1)
            refineLane<N>(lowestBit(m), x, y, edge);
        u = load(edge[0], f), v = load(edge[1], f), w = load(edge[2], f);
        inside &= lessEqual(zero, min(min(u, v), w)) | lessEqual(max(max(u, v), w), zero);
    }
    const F det = (u + v) + w;
    // A power of two, which changes only the range: products of three lengths would exceed that of
    // floats even in moderately large or small scenes.
    const F k = inversePower(det);
    const F t = ((((u * k) * az + (v * k) * bz) + (w * k) * cz) * r.sz) / (det * k);
    // A zero or NaN determinant gives a NaN or infinite t; infinity may equal tmax.
    const Mask hits = inside & lessEqual(tmin, t) & lessEqual(t, tmax) & ~equal(det, zero);
    if (hits) {
        store(out.t, t);
        store(out.v, v);
        store(out.w, w);
        store(out.det, det);
    }
    return hits;
}

// As above, for the triangles of a leaf and one ray.
template <unsigned N, class F, class Leaf>
SUNSTONE_INLINE Mask testTriangles(const Leaf& leaf, const RaySetup& setup, float tmax,
                                   TriangleCandidates<N>& out) {
    F* const f = nullptr;
    const RaySetup& s = reloaded(setup);
    return testTriangles<N, F>(leaf, s.axis, shearLanes<F>(s), splat(s.tmin, f), splat(tmax, f),
                               out);
}

} // namespace sunstone::bvh::SUNSTONE_ISA
