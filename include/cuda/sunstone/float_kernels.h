// SPDX-License-Identifier: Apache-2.0
// Elementary functions of device code in single precision: arithmetic of floats alone, because many
// GPUs have few units for doubles. Double appears only in the reduction of angles beyond 131,072.
//
// Method: argument reduction with a constant in two or three parts and fma, then a polynomial whose
// coefficients minimise the largest relative error (Remez exchange). Bounds in units of the last
// place, to which tests/cuda/apps/float_mathematics.cu holds them:
//   log, log2, sinpi, cospi 1; sin, cos, exp, exp2, exp10, log10, asin, acos, atan, tanh, hypot 2;
//   atan2, sinh, cosh 3; tan, pow 4; fmod is exact
#ifndef SUNSTONE_FLOAT_KERNELS_H
#define SUNSTONE_FLOAT_KERNELS_H

#include "math_kernels.h"

namespace sunstone_math {

SUNSTONE_DEVICE float absolute(float x) {
    return __builtin_fabsf(x);
}
SUNSTONE_DEVICE float infinityF() {
    return __int_as_float(0x7f800000);
}
SUNSTONE_DEVICE float quietNanF() {
    return __int_as_float(0x7fc00000);
}
SUNSTONE_DEVICE float withSign(float x, float sign) {
    return __builtin_copysignf(x, sign);
}

// ---- sine and cosine --------------------------------------------------------------------------

// x - q * pi/2 with |result| <= pi/4 for |x| >= 2^17: multiplies the mantissa with the bits of 2/pi
// that matter (Payne and Hanek).
SUNSTONE_MATH float reduceHuge(float x, int* quadrant) {
    static const unsigned int twoOverPi[8] = {0,           0xA2F9836Eu, 0x4E441529u, 0xFC2757D1u,
                                              0xF534DDC0u, 0xDB629599u, 0x3C439041u, 0xFE5163ABu};
    const unsigned int bits = (unsigned int)__float_as_int(x);
    const unsigned int mantissa = (bits & 0x7fffffu) | 0x800000u;
    // x = mantissa * 2^exponent. Bits of 2/pi of weight 2^(2 - exponent) and above add multiples of
    // 4 quadrants, so the 96 bits below them are enough.
    const int exponent = int((bits >> 23) & 0xff) - 150;
    const unsigned int* const word = twoOverPi + ((exponent + 30) >> 5);
    const unsigned int shift = (unsigned int)(exponent + 30) & 31;
    const unsigned int w0 = __funnelshift_l(word[1], word[0], shift),
                       w1 = __funnelshift_l(word[2], word[1], shift),
                       w2 = __funnelshift_l(word[3], word[2], shift);
    // In units of 2^-62 quadrants, modulo 4 quadrants.
    const unsigned long long product = ((unsigned long long)(mantissa * w0) << 32) +
                                       (unsigned long long)mantissa * w1 + __umulhi(mantissa, w2);
    const long long fraction = (long long)(product << 2); // of the nearest quadrant, in 2^-64
    const int q = int(product >> 62) + (fraction < 0);
    const float r = (float)((double)fraction * 0x1.921fb54442d18p-64);
    const bool isNegative = int(bits) < 0;
    *quadrant = isNegative ? -q : q;
    return x - x == 0 ? (isNegative ? -r : r) : quietNanF();
}

SUNSTONE_DEVICE float reduceHalfPi(float x, int* quadrant) {
    if (!(absolute(x) < 131072.0f))
        return reduceHuge(x, quadrant);
    const int q = __float2int_rn(x * 0x1.45f306p-1f);
    const float n = (float)q;
    // All parts are positive, so that -0 stays -0.
    float r = __builtin_fmaf(n, -0x1.921fb4p+0f, x);
    r = __builtin_fmaf(n, -0x1.4442dp-24f, r);
    *quadrant = q;
    return __builtin_fmaf(n, -0x1.84698ap-48f, r);
}

// The sine of r + quadrant * pi/2, |r| <= 0.8.
SUNSTONE_DEVICE float quadrantSine(float r, int quadrant) {
    const bool isCosine = quadrant & 1;
    const float z = r * r, base = isCosine ? 1.0f : r;
    float p = isCosine ? 0x1.99d83ap-16f : 0x1.7b20a6p-19f;
    p = __builtin_fmaf(p, z, isCosine ? -0x1.6c0c08p-10f : -0x1.a05636p-13f);
    p = __builtin_fmaf(p, z, isCosine ? 0x1.55554ap-5f : 0x1.111172p-7f);
    p = __builtin_fmaf(p, z, isCosine ? -0.5f : -0x1.555556p-3f);
    const float s = __builtin_fmaf(z * base, p, base);
    return quadrant & 2 ? -s : s;
}

SUNSTONE_MATH float sine(float x) {
    int q;
    const float r = reduceHalfPi(x, &q);
    return x == 0 ? x : quadrantSine(r, q);
}
SUNSTONE_MATH float cosine(float x) {
    int q;
    const float r = reduceHalfPi(x, &q);
    return quadrantSine(r, q + 1);
}
SUNSTONE_MATH void sinCos(float x, float* s, float* c) {
    int q;
    const float r = reduceHalfPi(x, &q);
    *s = x == 0 ? x : quadrantSine(r, q);
    *c = quadrantSine(r, q + 1);
}
SUNSTONE_MATH float tangent(float x) {
    int q;
    const float r = reduceHalfPi(x, &q);
    return x == 0 ? x : quadrantSine(r, q) / quadrantSine(r, q + 1);
}

// The sine of pi * (r + quadrant / 2), |r| <= 1/4.
SUNSTONE_DEVICE float quadrantSinePi(float r, int quadrant) {
    const bool isCosine = quadrant & 1;
    const float z = r * r;
    float p = isCosine ? 0x1.d47d48p-3f : 0x1.44510cp-4f;
    p = __builtin_fmaf(p, z, isCosine ? -0x1.55b146p+0f : -0x1.32adccp-1f);
    p = __builtin_fmaf(p, z, isCosine ? 0x1.03c1aep+2f : 0x1.466b78p+1f);
    p = __builtin_fmaf(p, z, isCosine ? -0x1.3bd3ccp+2f : -0x1.4abbcep+2f);
    const float low = __builtin_fmaf(z * r, p, r * -0x1.777a5cp-24f);
    const float s = isCosine ? __builtin_fmaf(z, p, 1.0f) : __builtin_fmaf(r, 0x1.921fb6p+1f, low);
    return quadrant & 2 ? -s : s;
}
SUNSTONE_MATH void sinCosPi(float x, float* s, float* c) {
    const float y = absolute(x) < 0x1p24f ? x : 0.0f * x; // large floats are even
    const float n = __builtin_rintf(2 * y);
    const float r = __builtin_fmaf(-0.5f, n, y); // exact
    const int q = __float2int_rn(__builtin_fmaf(-4.0f, __builtin_floorf(0.25f * n), n));
    const float sine = quadrantSinePi(r, q), cosine = quadrantSinePi(r, q + 1);
    *s = sine == 0 ? withSign(0.0f, x) : sine;
    *c = cosine == 0 ? 0.0f : cosine;
}

// ---- exponential and logarithm ----------------------------------------------------------------

SUNSTONE_DEVICE float powerOfTwo(int n) {
    return __int_as_float((n + 127) << 23);
}
// e^t - 1, |t| <= 0.36.
SUNSTONE_DEVICE float smallExpMinus1(float t) {
    float p = __builtin_fmaf(0x1.6cf3b2p-10f, t, 0x1.1241ep-7f);
    p = __builtin_fmaf(p, t, 0x1.555528p-5f);
    p = __builtin_fmaf(p, t, 0x1.555486p-3f);
    p = __builtin_fmaf(p, t, 0.5f);
    return __builtin_fmaf(p, t * t, t);
}
// e^t * 2^n, -300 < n < 250: in two steps, as 2^n may be out of range. Callers convert with
// __float2int_rn(), which unlike a cast is defined for NaN.
SUNSTONE_DEVICE float expTimesPower(float t, int n) {
    const int half = n >> 1;
    return (smallExpMinus1(t) + 1.0f) * powerOfTwo(half) * powerOfTwo(n - half);
}
// x clamped to an interval that exceeds the range of the result; a NaN stays.
SUNSTONE_DEVICE float clampExponent(float x, float low, float high) {
    const float y = x < low ? low : x;
    return y > high ? high : y;
}
// e^x * 2^shift.
SUNSTONE_DEVICE float exponentialTimes(float x, int shift) {
    const float y = clampExponent(x, -106.0f, 91.0f);
    const float n = __builtin_rintf(y * 0x1.715476p+0f);
    const float t = __builtin_fmaf(n, 0x1.05c61p-29f, __builtin_fmaf(n, -0x1.62e43p-1f, y));
    return expTimesPower(t, __float2int_rn(n) + shift);
}
SUNSTONE_MATH float exponential(float x) {
    return exponentialTimes(x, 0);
}
SUNSTONE_MATH float exponential2(float x) {
    const float y = clampExponent(x, -152.0f, 130.0f), n = __builtin_rintf(y);
    return expTimesPower((y - n) * 0x1.62e43p-1f, __float2int_rn(n));
}
SUNSTONE_MATH float exponential10(float x) {
    const float y = clampExponent(x, -47.0f, 40.0f);
    const float n = __builtin_rintf(y * 0x1.a934fp+1f);
    const float t = __builtin_fmaf(n, 0x1.ec10cp-27f, __builtin_fmaf(n, -0x1.344136p-2f, y));
    // t * ln 10, with the rounding error of the constant.
    return expTimesPower(__builtin_fmaf(t, 0x1.26bb1cp+1f, t * -0x1.12aabap-25f),
                         __float2int_rn(n));
}

// x = (1 + f) * 2^e with 1 + f between sqrt(1/2) and sqrt(2), for positive finite x.
struct Mantissa {
    float f, e;
};
SUNSTONE_DEVICE Mantissa splitFloat(float x) {
    const bool isSmall = x < 0x1p-126f;
    const int bits = __float_as_int(isSmall ? x * 0x1p23f : x);
    const int above = bits - 0x3f3504f3; // the bits of sqrt(1/2)
    const Mantissa m = {__int_as_float(bits - (above & ~0x7fffff)) - 1.0f,
                        (float)((above >> 23) - (isSmall ? 23 : 0))};
    return m;
}
// log(1 + f) - f.
SUNSTONE_DEVICE float logTail(float f) {
    float p = __builtin_fmaf(-0x1.38c8a0p-4f, f, 0x1.056656p-3f);
    p = __builtin_fmaf(p, f, -0x1.0d86eep-3f);
    p = __builtin_fmaf(p, f, 0x1.22d8c8p-3f);
    p = __builtin_fmaf(p, f, -0x1.5471fap-3f);
    p = __builtin_fmaf(p, f, 0x1.99a014p-3f);
    p = __builtin_fmaf(p, f, -0x1.000228p-2f);
    p = __builtin_fmaf(p, f, 0x1.555554p-2f);
    const float z = f * f;
    return __builtin_fmaf(z * f, p, -0.5f * z);
}
// False for numbers that are not positive or not finite.
SUNSTONE_DEVICE bool hasLogarithm(float x) {
    return x > 0 && x < infinityF();
}
SUNSTONE_DEVICE float logOfRest(float x) {
    return x == 0 ? -infinityF() : x < 0 ? quietNanF() : x;
}
SUNSTONE_MATH float logarithm(float x) {
    if (!hasLogarithm(x))
        return logOfRest(x);
    const Mantissa m = splitFloat(x);
    const float low = __builtin_fmaf(m.e, -0x1.05c61p-29f, logTail(m.f));
    return __builtin_fmaf(m.e, 0x1.62e43p-1f, m.f + low);
}
// (e * one + log(1 + f)) * scale for a logarithm of another base.
SUNSTONE_DEVICE float scaledLogarithm(float x, float scaleHigh, float scaleLow, float oneHigh,
                                      float oneLow) {
    const Mantissa m = splitFloat(x);
    const float high = __fmul_rn(m.f, scaleHigh); // exactly this product counts below
    const float rest = __builtin_fmaf(m.f, scaleLow, __builtin_fmaf(m.f, scaleHigh, -high));
    const float low = __builtin_fmaf(logTail(m.f), scaleHigh, __builtin_fmaf(m.e, oneLow, rest));
    return __builtin_fmaf(m.e, oneHigh, high + low);
}
SUNSTONE_MATH float logarithm2(float x) {
    return hasLogarithm(x) ? scaledLogarithm(x, 0x1.715476p+0f, 0x1.4ae0cp-26f, 1.0f, 0.0f)
                           : logOfRest(x);
}
SUNSTONE_MATH float logarithm10(float x) {
    return hasLogarithm(x) ? scaledLogarithm(x, 0x1.bcb7b2p-2f, -0x1.5b235ep-27f, 0x1.344136p-2f,
                                             -0x1.ec10cp-27f)
                           : logOfRest(x);
}

// ---- powers -----------------------------------------------------------------------------------

// x^y for positive finite x and finite y. The logarithm is a pair, because the product with y
// magnifies its error up to 2^7 times.
SUNSTONE_DEVICE float positivePower(float x, float y) {
    const Mantissa m = splitFloat(x);
    // log2(1 + f) = 2 / ln 2 * atanh(s), s = f / (2 + f)
    const float d = 2.0f + m.f, dLow = m.f - (d - 2.0f), inverse = 1.0f / d;
    const float s = m.f * inverse;
    const float sLow = __builtin_fmaf(-s, dLow, __builtin_fmaf(-s, d, m.f)) * inverse;
    const float z = s * s;
    float p = __builtin_fmaf(0x1.58b424p-2f, z, 0x1.a5cebep-2f);
    p = __builtin_fmaf(p, z, 0x1.2776e2p-1f);
    p = __builtin_fmaf(p, z, 0x1.ec709ep-1f);
    const float high = __fmul_rn(s, 0x1.715476p+1f);
    float low = __builtin_fmaf(s, 0x1.715476p+1f, -high);
    low = __builtin_fmaf(s, 0x1.4ae0cp-25f, __builtin_fmaf(sLow, 0x1.715476p+1f, low));
    low = __builtin_fmaf(z * s, p, low);
    const float head = high + low, tail = low - (head - high);
    const float log = m.e + head, logLow = (head - (log - m.e)) + tail;
    const float by = clampExponent(y, -0x1p60f, 0x1p60f);
    const float product = __fmul_rn(log, by);
    const float rest = __builtin_fmaf(logLow, by, __builtin_fmaf(log, by, -product));
    const float limited = clampExponent(product, -160.0f, 140.0f), n = __builtin_rintf(limited);
    const float fraction = limited == product ? (product - n) + rest : 0.0f;
    return expTimesPower(fraction * 0x1.62e43p-1f, __float2int_rn(n));
}
SUNSTONE_MATH float power(float x, float y) {
    if (x == 1 || y == 0)
        return 1;
    if (x != x || y != y)
        return x + y;
    const float size = absolute(x), half = 0.5f * y;
    const bool isInteger = __builtin_truncf(y) == y;
    const bool isOdd = isInteger && __builtin_truncf(half) != half && absolute(y) < 0x1p24f;
    float r;
    if (absolute(y) == infinityF())
        r = size == 1 ? 1.0f : (size > 1) == (y > 0) ? infinityF() : 0.0f;
    else if (size == 0 || size == infinityF())
        r = (size == 0) == (y < 0) ? infinityF() : 0.0f;
    else
        r = x < 0 && !isInteger ? quietNanF() : positivePower(size, y);
    return isOdd ? withSign(r, x) : r;
}

// ---- inverse functions ------------------------------------------------------------------------

// atan(t), 0 <= t <= 1.
SUNSTONE_DEVICE float smallArcTangent(float t) {
    const float z = t * t;
    float p = __builtin_fmaf(0x1.860274p-9f, z, -0x1.0fbae2p-6f);
    p = __builtin_fmaf(p, z, 0x1.64d822p-5f);
    p = __builtin_fmaf(p, z, -0x1.36862ap-4f);
    p = __builtin_fmaf(p, z, 0x1.b56bc4p-4f);
    p = __builtin_fmaf(p, z, -0x1.231bcap-3f);
    p = __builtin_fmaf(p, z, 0x1.997aeap-3f);
    p = __builtin_fmaf(p, z, -0x1.5554e6p-2f);
    return __builtin_fmaf(z * t, p, t);
}
SUNSTONE_MATH float arcTangent(float x) {
    const float size = absolute(x);
    const float a = smallArcTangent(size > 1 ? 1.0f / size : size);
    const float r = size > 1 ? 0x1.921fb6p+0f - (a + 0x1.777a5cp-25f) : a;
    return x == x ? withSign(r, x) : x;
}
SUNSTONE_MATH float arcTangent2(float y, float x) {
    if (x != x || y != y)
        return x + y;
    const float sizeX = absolute(x), sizeY = absolute(y);
    const bool isSteep = sizeY > sizeX;
    const float low = isSteep ? sizeX : sizeY, high = isSteep ? sizeY : sizeX;
    // Both zero: 0; both infinite: 1. A quotient of large numbers may be subnormal, but is correct.
    const float t = high == 0 ? 0.0f : low == high ? 1.0f : low / high;
    float a = smallArcTangent(t);
    a = isSteep ? 0x1.921fb6p+0f - (a + 0x1.777a5cp-25f) : a;
    a = __float_as_int(x) < 0 ? 0x1.921fb6p+1f - (a + 0x1.777a5cp-24f) : a;
    return withSign(a, y);
}
// asin(t) - t, 0 <= t <= 1/2; z = t * t.
SUNSTONE_DEVICE float arcSineTail(float t, float z) {
    float p = __builtin_fmaf(0x1.59dd5cp-5f, z, 0x1.8ba494p-6f);
    p = __builtin_fmaf(p, z, 0x1.748b78p-5f);
    p = __builtin_fmaf(p, z, 0x1.330162p-4f);
    p = __builtin_fmaf(p, z, 0x1.5555cap-3f);
    return z * t * p;
}
// Uses half of 1 - x, whose root is the sine of half the angle between the result and pi/2.
SUNSTONE_MATH float arcSine(float x) {
    const float size = absolute(x), rest = __builtin_fmaf(-0.5f, size, 0.5f);
    const bool isLarge = size > 0.5f;
    const float z = isLarge ? rest : size * size;
    const float t = isLarge ? __builtin_sqrtf(rest) : size;
    const float tail = arcSineTail(t, z);
    const float r =
        isLarge ? __builtin_fmaf(-2.0f, t + (tail + 0x1.777a5cp-26f), 0x1.921fb6p+0f) : t + tail;
    return withSign(r, x);
}
SUNSTONE_MATH float arcCosine(float x) {
    const float size = absolute(x), rest = __builtin_fmaf(-0.5f, size, 0.5f);
    if (size > 0.5f) {
        const float t = __builtin_sqrtf(rest), tail = arcSineTail(t, rest);
        return x > 0 ? 2 * (t + tail)
                     : __builtin_fmaf(-2.0f, t + (tail + 0x1.777a5cp-25f), 0x1.921fb6p+1f);
    }
    const float tail = arcSineTail(x, x * x);
    return 0x1.921fb6p+0f - (x + (tail + 0x1.777a5cp-25f));
}

// ---- hyperbolic functions, lengths, remainders ------------------------------------------------

SUNSTONE_MATH float hyperbolicSine(float x) {
    const float size = absolute(x);
    if (size < 1) {
        const float z = x * x;
        const float p =
            __builtin_fmaf(__builtin_fmaf(0x1.ab5438p-13f, z, 0x1.10f6fap-7f), z, 0x1.55559ap-3f);
        return __builtin_fmaf(z * x, p, x);
    }
    const float half = exponentialTimes(size, -1);
    return withSign(__builtin_fmaf(-0.25f, 1.0f / half, half), x);
}
SUNSTONE_MATH float hyperbolicCosine(float x) {
    const float half = exponentialTimes(absolute(x), -1);
    return __builtin_fmaf(0.25f, 1.0f / half, half);
}
SUNSTONE_MATH float hyperbolicTangent(float x) {
    const float size = absolute(x);
    if (size < 0.55f) {
        const float z = x * x;
        float p = __builtin_fmaf(-0x1.977844p-8f, z, 0x1.58a54ep-6f);
        p = __builtin_fmaf(p, z, -0x1.b91882p-5f);
        p = __builtin_fmaf(p, z, 0x1.110cd8p-3f);
        p = __builtin_fmaf(p, z, -0x1.55554ap-2f);
        return withSign(__builtin_fmaf(z * x, p, x), x);
    }
    return withSign(__builtin_fmaf(-2.0f, 1.0f / (exponentialTimes(2 * size, 0) + 1.0f), 1.0f), x);
}

// Scaled by a power of two, so that squares do not overflow or underflow.
SUNSTONE_MATH float hypotenuse(float x, float y) {
    const float a = absolute(x), b = absolute(y);
    if (a == infinityF() || b == infinityF())
        return infinityF();
    const float high = a > b ? a : b;
    const float scale = high > 0x1p62f ? 0x1p-66f : high < 0x1p-60f ? 0x1p90f : 1.0f;
    const float back = high > 0x1p62f ? 0x1p66f : high < 0x1p-60f ? 0x1p-90f : 1.0f;
    const float c = a * scale, d = b * scale;
    return __builtin_sqrtf(__builtin_fmaf(c, c, d * d)) * back;
}

// x - n * y with n = trunc(x / y) and 0 <= x / y < 2^23: exact.
SUNSTONE_DEVICE float shortModulo(float x, float y) {
    const float n = __builtin_truncf(x / y), r = __builtin_fmaf(-n, y, x);
    return r < 0 ? r + y : r >= y ? r - y : r; // the quotient may have been rounded up to n
}
// In steps of a multiple of y by a power of two, each of which keeps the remainder.
SUNSTONE_MATH float modulo(float x, float y) {
    const float divisor = absolute(y);
    float r = absolute(x);
    if (!(r < infinityF()) || !(divisor > 0))
        return quietNanF();
    if (divisor == infinityF())
        return x;
    const bool isSmall = divisor < 0x1p-100f; // it may be subnormal
    const int exponent =
        (__float_as_int(isSmall ? divisor * 0x1p100f : divisor) >> 23) - (isSmall ? 100 : 0);
    while (r >= divisor * 0x1p22f) {
        const int steps = (__float_as_int(r) >> 23) - exponent - 21, half = steps >> 1;
        r = shortModulo(r, divisor * powerOfTwo(half) * powerOfTwo(steps - half));
    }
    return withSign(shortModulo(r, divisor), x);
}

} // namespace sunstone_math

#endif
