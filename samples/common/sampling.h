// SPDX-License-Identifier: Apache-2.0
// Random directions for host and device code. Sines come from a polynomial, because the C library
// and device compilers round sines differently and pictures should be equal.
#pragma once

#include "vec.h"

constexpr float kPi = 3.14159265f;

// A hash whose bits are all usable (O'Neill 2014).
SAMPLE_INLINE unsigned hashPcg(unsigned value) {
    unsigned state = value * 747796405u + 2891336453u;
    unsigned word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// sin(2 pi x) for x in [-0.25, 0.25]: interpolated at Chebyshev nodes, error below 1e-7.
SAMPLE_INLINE float sineOfTurns(float x) {
    float square = x * x;
    float polynomial = 39.7598271f;
    polynomial = polynomial * square - 76.5811726f;
    polynomial = polynomial * square + 81.6024764f;
    polynomial = polynomial * square - 41.3416806f;
    polynomial = polynomial * square + 6.28318528f;
    return x * polynomial;
}
// A point on the unit circle; x = cos, y = sin of `turns` in [0, 1).
SAMPLE_INLINE float2 circlePoint(float turns) {
    // sin(2 pi t) = sin(2 pi (0.5 - t)): fold into the polynomial's range.
    float shifted = turns - 0.5f; // [-0.5, 0.5)
    float sine = shifted < -0.25f ? -0.5f - shifted : shifted > 0.25f ? 0.5f - shifted : shifted;
    float cosine = 0.25f - (shifted < 0.0f ? -shifted : shifted);
    float2 point;
    point.x = -sineOfTurns(cosine);
    point.y = -sineOfTurns(sine);
    return point;
}

// Two vectors that complete the unit vector `z` to a right-handed basis (Duff et al. 2017).
SAMPLE_INLINE void makeBasis(float3 z, float3& x, float3& y) {
    float sign = z.z < 0.0f ? -1.0f : 1.0f;
    float a = -1.0f / (sign + z.z);
    float b = z.x * z.y * a;
    x = vec(1.0f + sign * z.x * z.x * a, sign * b, -sign * z.x);
    y = vec(b, sign + z.y * z.y * a, -z.y);
}
SAMPLE_INLINE float3 fromBasis(float3 x, float3 y, float3 z, float3 v) {
    return x * v.x + y * v.y + z * v.z;
}

// A direction on the side of the unit vector `normal`, cosine-weighted, from two numbers in [0, 1).
SAMPLE_INLINE float3 cosineDirection(float3 normal, float u, float v) {
    float3 x, y;
    makeBasis(normal, x, y);
    float2 circle = circlePoint(v);
    float radius = sqrtf(u);
    return fromBasis(x, y, normal, vec(radius * circle.x, radius * circle.y, sqrtf(1.0f - u)));
}
