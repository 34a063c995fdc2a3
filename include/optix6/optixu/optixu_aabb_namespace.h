// SPDX-License-Identifier: Apache-2.0
// Axis-aligned boxes, for host and device: bounding box programs write one. optixu_aabb.h makes the
// name visible outside namespace optix. Source: OptiX API reference 6.0, sections 7.1, 8.30.
#ifndef SUNSTONE_OPTIXU_AABB_NAMESPACE_H
#define SUNSTONE_OPTIXU_AABB_NAMESPACE_H

#include "optixu_math_namespace.h"

// Checks of arguments on the host. Device code has none.
#ifndef RT_AABB_ASSERT
#ifdef __CUDACC__
#define RT_AABB_ASSERT(condition)
#else
#include <assert.h>
#define RT_AABB_ASSERT assert
#endif
#endif

namespace optix {

/** The points p with m_min <= p <= m_max. A box with m_min > m_max along an axis is invalid: it
    contains no point. Functions that return a position or a size need a valid box. */
class Aabb {
public:
    /** An invalid box; include makes it the box of its argument. */
    RT_HOSTDEVICE Aabb() { invalidate(); }
    RT_HOSTDEVICE Aabb(const float3& min, const float3& max) { set(min, max); }
    /** The box of a triangle. */
    RT_HOSTDEVICE Aabb(const float3& v0, const float3& v1, const float3& v2) { set(v0, v1, v2); }

    /** Whether all six numbers are equal. */
    RT_HOSTDEVICE bool operator==(const Aabb& other) const {
        return equal(m_min, other.m_min) && equal(m_max, other.m_max);
    }
    /** m_min for 0, m_max for 1. */
    RT_HOSTDEVICE float3& operator[](int i) {
        RT_AABB_ASSERT(i == 0 || i == 1);
        return i == 0 ? m_min : m_max;
    }
    RT_HOSTDEVICE const float3& operator[](int i) const {
        RT_AABB_ASSERT(i == 0 || i == 1);
        return i == 0 ? m_min : m_max;
    }

    RT_HOSTDEVICE void set(const float3& min, const float3& max) {
        m_min = min;
        m_max = max;
    }
    RT_HOSTDEVICE void set(const float3& v0, const float3& v1, const float3& v2) {
        m_min = fminf(v0, fminf(v1, v2));
        m_max = fmaxf(v0, fmaxf(v1, v2));
    }
    RT_HOSTDEVICE void invalidate() {
        m_min = make_float3(1e37f);
        m_max = make_float3(-1e37f);
    }
    RT_HOSTDEVICE bool valid() const { return lessEqual(m_min, m_max); }

    RT_HOSTDEVICE bool contains(const float3& p) const {
        return lessEqual(m_min, p) && lessEqual(p, m_max);
    }
    /** Whether the whole of bb is inside. */
    RT_HOSTDEVICE bool contains(const Aabb& bb) const {
        return lessEqual(m_min, bb.m_min) && lessEqual(bb.m_max, m_max);
    }

    RT_HOSTDEVICE void include(const float3& p) { include(p, p); }
    RT_HOSTDEVICE void include(const Aabb& other) { include(other.m_min, other.m_max); }
    RT_HOSTDEVICE void include(const float3& min, const float3& max) {
        m_min = fminf(m_min, min);
        m_max = fmaxf(m_max, max);
    }

    RT_HOSTDEVICE float3 center() const {
        RT_AABB_ASSERT(valid());
        return 0.5f * (m_min + m_max);
    }
    RT_HOSTDEVICE float center(int dim) const {
        RT_AABB_ASSERT(dim >= 0 && dim < 3);
        return getByIndex(center(), dim);
    }
    RT_HOSTDEVICE float3 extent() const {
        RT_AABB_ASSERT(valid());
        return m_max - m_min;
    }
    RT_HOSTDEVICE float extent(int dim) const {
        RT_AABB_ASSERT(dim >= 0 && dim < 3);
        return getByIndex(extent(), dim);
    }
    RT_HOSTDEVICE float volume() const {
        const float3 d = extent();
        return d.x * d.y * d.z;
    }
    /** The area of the surface, and half of it. */
    RT_HOSTDEVICE float area() const { return 2.0f * halfArea(); }
    RT_HOSTDEVICE float halfArea() const {
        const float3 d = extent();
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
    /** The axis with the largest extent; of equal ones the first. */
    RT_HOSTDEVICE int longestAxis() const {
        const float3 d = extent();
        if (d.x >= d.y)
            return d.x >= d.z ? 0 : 2;
        return d.y >= d.z ? 1 : 2;
    }
    RT_HOSTDEVICE float maxExtent() const { return fmaxf(extent()); }
    /** Whether an extent is 0. */
    RT_HOSTDEVICE bool isFlat() const {
        return m_min.x == m_max.x || m_min.y == m_max.y || m_min.z == m_max.z;
    }

    /** Whether the boxes share a point. */
    RT_HOSTDEVICE bool intersects(const Aabb& other) const {
        return lessEqual(m_min, other.m_max) && lessEqual(other.m_min, m_max);
    }
    /** Keeps the points that are also in other; an invalid box if there are none. */
    RT_HOSTDEVICE void intersection(const Aabb& other) {
        m_min = fmaxf(m_min, other.m_min);
        m_max = fminf(m_max, other.m_max);
    }
    /** Moves each side outwards. */
    RT_HOSTDEVICE void enlarge(float amount) {
        RT_AABB_ASSERT(valid());
        m_min = m_min - amount;
        m_max = m_max + amount;
    }

    /** The distance of x from the box, and its square: 0 inside. */
    RT_HOSTDEVICE float distance(const float3& x) const { return ::sqrtf(distance2(x)); }
    RT_HOSTDEVICE float distance2(const float3& x) const {
        const float3 outside = fmaxf(fmaxf(m_min - x, x - m_max), make_float3(0.0f));
        return dot(outside, outside);
    }
    /** The distance of x from the surface, negative inside. */
    RT_HOSTDEVICE float signedDistance(const float3& x) const {
        const float nearest = fmaxf(fmaxf(m_min - x, x - m_max));
        return nearest < 0.0f ? nearest : distance(x);
    }

    float3 m_min;
    float3 m_max;

private:
    static RT_HOSTDEVICE bool equal(const float3& a, const float3& b) {
        return a.x == b.x && a.y == b.y && a.z == b.z;
    }
    static RT_HOSTDEVICE bool lessEqual(const float3& a, const float3& b) {
        return a.x <= b.x && a.y <= b.y && a.z <= b.z;
    }
};

} // namespace optix

#endif
