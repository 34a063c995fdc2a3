// SPDX-License-Identifier: Apache-2.0
// Implementation of optix_micromap.h. Include that instead.
//
// The curve visits the four parts of a triangle (A, B, C) with edge midpoints AB, BC and AC as
//
//   0: (A, AB, AC)   1: (AC, BC, AB)   2: (AB, B, BC)   3: (BC, AC, C)
//
// and each part in the same way. Two bits of the number, from the highest, select the part at each
// level. Corners are multiples of 2^-level: a MicroVertex has integers, whose unit halves at each
// level.
#ifndef SUNSTONE_OPTIX76_OPTIX_7_MICROMAP_IMPL_H
#define SUNSTONE_OPTIX76_OPTIX_7_MICROMAP_IMPL_H

#if !defined(__CUDACC_RTC__) /* has the types itself */
#include <vector_functions.h>
#include <vector_types.h>
#endif

#ifndef OPTIX_MICROMAP_FUNC
#if defined(__CUDACC__) || defined(__CUDA__)
#define OPTIX_MICROMAP_FUNC __host__ __device__
#else
#define OPTIX_MICROMAP_FUNC
#endif
#endif

#ifndef OPTIX_MICROMAP_INLINE_FUNC
#define OPTIX_MICROMAP_INLINE_FUNC OPTIX_MICROMAP_FUNC inline
#endif

namespace optix_impl {

/** A corner in steps of 2^-level. */
struct MicroVertex {
    unsigned int u, v;
};

OPTIX_MICROMAP_INLINE_FUNC MicroVertex sumOf(MicroVertex a, MicroVertex b) {
    const MicroVertex sum = {a.u + b.u, a.v + b.v};
    return sum;
}

OPTIX_MICROMAP_INLINE_FUNC float2 barycentricsOf(MicroVertex a, float step) {
    return make_float2(static_cast<float>(a.u) * step, static_cast<float>(a.v) * step);
}

/** Replaces the triangle by a part of it, in steps of half the size. */
OPTIX_MICROMAP_INLINE_FUNC void enterPart(unsigned int part, MicroVertex& a, MicroVertex& b,
                                          MicroVertex& c) {
    const MicroVertex ab = sumOf(a, b), bc = sumOf(b, c), ac = sumOf(a, c);
    const MicroVertex doubleA = sumOf(a, a), doubleB = sumOf(b, b), doubleC = sumOf(c, c);
    a = part == 0 ? doubleA : part == 1 ? ac : part == 2 ? ab : bc;
    b = part == 0 ? ab : part == 1 ? bc : part == 2 ? doubleB : ac;
    c = part == 0 ? ac : part == 1 ? ab : part == 2 ? bc : doubleC;
}

OPTIX_MICROMAP_INLINE_FUNC void cornersOfMicroTriangle(unsigned int index, unsigned int level,
                                                       float2& corner, float2& alongU,
                                                       float2& alongV) {
    MicroVertex a = {0, 0}, b = {1, 0}, c = {0, 1};
    float step = 1.0f;
    for (unsigned int i = level; i > 0; --i) {
        enterPart(index >> (2 * (i - 1)) & 3u, a, b, c);
        step *= 0.5f;
    }
    // The right angle is where one corner shares u with another and v with the third.
    const MicroVertex right = (a.u == b.u || a.u == c.u) && (a.v == b.v || a.v == c.v)   ? a
                              : (b.u == a.u || b.u == c.u) && (b.v == a.v || b.v == c.v) ? b
                                                                                         : c;
    const unsigned int otherU = a.u + b.u + c.u - 2 * right.u;
    const unsigned int otherV = a.v + b.v + c.v - 2 * right.v;
    const MicroVertex u = {otherU, right.v}, v = {right.u, otherV};
    corner = barycentricsOf(right, step);
    alongU = barycentricsOf(u, step);
    alongV = barycentricsOf(v, step);
}

} // namespace optix_impl

#endif
