// SPDX-License-Identifier: Apache-2.0
// The watertight ray/triangle test, with the operations of the CPU's test
// (bvh/walk/ray_triangle.h), so that both report equal t, u and v. For rays with a negative z
// direction, the axes are not swapped; the sign of the edge functions is inverted instead, which is
// exact.
#pragma once

#include "bvh/gpu/portable.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

struct Shear {
    uint32_t axis; // the direction's longest; bit 2: negative
    float x, y, z;
};

// The ratio of products to the area above which the rounding of the products matters.
constexpr float kSliver = 128;

struct TriangleHit {
    float t;
    float v, w,
        det; // edge functions; u = v / det, v = w / det as programs see them; front: det > 0
};

SUNSTONE_INLINE Shear makeShear(const float d[3]) {
    const float ax = magnitude(d[0]), ay = magnitude(d[1]), az = magnitude(d[2]);
    Shear s;
    s.axis = ax > ay ? (ax > az ? 0 : 2) : (ay > az ? 1 : 2);
    const float z = s.axis == 0 ? d[0] : s.axis == 1 ? d[1] : d[2];
    const float x = s.axis == 0 ? d[1] : s.axis == 1 ? d[2] : d[0];
    const float y = s.axis == 0 ? d[2] : s.axis == 1 ? d[0] : d[1];
    s.x = divide(x, z);
    s.y = divide(y, z);
    s.z = divide(1.0f, z);
    s.axis |= z < 0 ? 4u : 0u;
    return s;
}

// A vertex in the sheared space of the ray.
struct Sheared {
    float x, y, z;
};

SUNSTONE_INLINE Sheared shearVertex(const Shear& s, const float org[3], float vx, float vy,
                                    float vz) {
    const float dx = sub(vx, org[0]), dy = sub(vy, org[1]), dz = sub(vz, org[2]);
    const uint32_t axis = s.axis & 3;
    Sheared r;
    r.z = axis == 0 ? dx : axis == 1 ? dy : dz;
    r.x = sub(axis == 0 ? dy : axis == 1 ? dz : dx, mul(s.x, r.z));
    r.y = sub(axis == 0 ? dz : axis == 1 ? dx : dy, mul(s.y, r.z));
    return r;
}

SUNSTONE_INLINE float exactEdge(const Sheared& b, const Sheared& c) {
    return float(sub(mul(double(c.x), double(b.y)), mul(double(c.y), double(b.x))));
}

SUNSTONE_INLINE bool sameSide(float u, float v, float w) {
    return smaller(smaller(u, v), w) >= 0 || larger(larger(u, v), w) <= 0;
}

// Whether the ray hits the triangle at tmin <= t <= tmax. a, b, c: its vertices; the fourth words
// are ignored.
SUNSTONE_INLINE bool testTriangle(const float org[3], const Shear& s, U4 a, U4 b, U4 c, float tmin,
                                  float tmax, TriangleHit& hit) {
    const Sheared p = shearVertex(s, org, floatOf(a.x), floatOf(a.y), floatOf(a.z));
    const Sheared q = shearVertex(s, org, floatOf(b.x), floatOf(b.y), floatOf(b.z));
    const Sheared r = shearVertex(s, org, floatOf(c.x), floatOf(c.y), floatOf(c.z));
    const float u0 = mul(r.x, q.y), u1 = mul(r.y, q.x);
    const float v0 = mul(p.x, r.y), v1 = mul(p.y, r.x);
    const float w0 = mul(q.x, p.y), w1 = mul(q.y, p.x);
    float u = sub(u0, u1), v = sub(v0, v1), w = sub(w0, w1);
    if (!sameSide(u, v, w))
        return false;
    const float products = larger(larger(add(magnitude(u0), magnitude(u1)), //
                                         add(magnitude(v0), magnitude(v1))),
                                  add(magnitude(w0), magnitude(w1)));
    if (u == 0 || v == 0 || w == 0 || mul(magnitude(add(add(u, v), w)), kSliver) <= products) {
        u = exactEdge(q, r);
        v = exactEdge(r, p);
        w = exactEdge(p, q);
        if (!sameSide(u, v, w))
            return false;
    }
    const float det = add(add(u, v), w);
    if (det == 0)
        return false;
    const float k = floatOf(0x7F000000u - (bitsOf(det) & 0x7F800000u));
    const float t =
        divide(mul(add(add(mul(mul(u, k), p.z), mul(mul(v, k), q.z)), mul(mul(w, k), r.z)), s.z),
               mul(det, k));
    if (!(tmin <= t && t <= tmax))
        return false;
    hit.t = add(t, 0.0f); // not -0: box tests compare a ray's end as an integer
    hit.v = v;
    hit.w = w;
    hit.det = det;
    if (s.axis & 4) {
        hit.v = -v;
        hit.w = -w;
        hit.det = -det;
    }
    return true;
}

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
