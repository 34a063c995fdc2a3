// SPDX-License-Identifier: Apache-2.0
// Elementary functions for device code, in double precision, from basic operations only, without a
// device library. The float functions of math.h round these results, so their errors are barely
// above half a unit in the last place.
//
// Method: argument reduction to a small interval, then the Taylor or atanh series up to the point
// where the next term no longer changes a double. Sums that need more than 53 bits are kept as
// pairs (hi + lo, lo less than an ulp of hi); products are split with fma.
#ifndef SUNSTONE_MATH_KERNELS_H
#define SUNSTONE_MATH_KERNELS_H

#include "intrinsics.h"

#define SUNSTONE_MATH static __inline__ __attribute__((device))

namespace sunstone_math {

struct Pair {
    double hi, lo;
};

SUNSTONE_DEVICE double infinity() {
    return __longlong_as_double(0x7ff0000000000000LL);
}
SUNSTONE_DEVICE double quietNan() {
    return __longlong_as_double(0x7ff8000000000000LL);
}
SUNSTONE_DEVICE double absolute(double x) {
    return __builtin_fabs(x);
}
SUNSTONE_DEVICE bool isNan(double x) {
    return x != x;
}
SUNSTONE_DEVICE double withSign(double x, double sign) {
    return __builtin_copysign(x, sign);
}

// Exact sum of two numbers; |a| >= |b|.
SUNSTONE_DEVICE Pair fastSum(double a, double b) {
    double hi = __dadd_rn(a, b);
    Pair r = {hi, __dsub_rn(b, __dsub_rn(hi, a))};
    return r;
}

// x * 2^n, also where 2^n itself is out of range.
SUNSTONE_MATH double scale(double x, int n) {
    if (n > 1023) {
        x *= __longlong_as_double(0x7fe0000000000000LL);
        n -= 1023;
        if (n > 1023) {
            x *= __longlong_as_double(0x7fe0000000000000LL);
            n = n - 1023 > 1023 ? 1023 : n - 1023;
        }
    } else if (n < -1022) {
        // 2^-969 keeps 53 bits above the subnormal range, so that only the last step rounds.
        const double small = __longlong_as_double((long long)(1023 - 969) << 52);
        x *= small;
        n += 969;
        if (n < -1022) {
            x *= small;
            n = n + 969 < -1022 ? -1022 : n + 969;
        }
    }
    return x * __longlong_as_double((long long)(n + 1023) << 52);
}

// ---- sine and cosine --------------------------------------------------------------------------

// x - q * pi/2 with |result| <= pi/4 for huge x: multiplies the mantissa with the relevant bits of
// 2/pi (Payne and Hanek).
SUNSTONE_MATH Pair reduceHuge(double x, int* quadrant) {
    static const unsigned long long twoOverPi[19] = {
        0xA2F9836E4E441529ULL, 0xFC2757D1F534DDC0ULL, 0xDB6295993C439041ULL, 0xFE5163ABDEBBC561ULL,
        0xB7246E3A424DD2E0ULL, 0x06492EEA09D1921CULL, 0xFE1DEB1CB129A73EULL, 0xE88235F52EBB4484ULL,
        0xE99C7026B45F7E41ULL, 0x3991D639835339F4ULL, 0x9C845F8BBDF9283BULL, 0x1FF897FFDE05980FULL,
        0xEF2F118B5A0A6D1FULL, 0x6D367ECF27CB09B7ULL, 0x4F463F669E5FEA2DULL, 0x7527BAC7EBE5F17BULL,
        0x3D0739F78A5292EAULL, 0x6BFB5FB11F8D5D08ULL, 0x56033046FC7B6BABULL};
    unsigned long long bits = (unsigned long long)__double_as_longlong(x);
    int exponent = int((bits >> 52) & 0x7ff) - 1023 - 52; // x = mantissa * 2^exponent
    unsigned long long mantissa = (bits & 0xfffffffffffffULL) | 0x10000000000000ULL;
    // Bits of 2/pi of weight above 2^(2 - exponent) only add multiples of 4 quadrants: start there,
    // so that the two highest bits of the product (mod 2^256) are the quadrant.
    int first = exponent - 2;
    int word = first >> 6, shift = first & 63; // word is -1 where exponent < 2
    unsigned long long w[4];
    for (int i = 0; i < 4; ++i) {
        int at = word + i;
        unsigned long long a = at >= 0 && at < 19 ? twoOverPi[at] : 0;
        unsigned long long b = at >= -1 && at < 18 ? twoOverPi[at + 1] : 0;
        w[i] = shift ? (a << shift) | (b >> (64 - shift)) : a;
    }
    unsigned long long p2 = mantissa * w[2], carry = __umul64hi(mantissa, w[3]);
    p2 += carry;
    carry = __umul64hi(mantissa, w[2]) + (p2 < carry);
    unsigned long long p1 = mantissa * w[1] + carry;
    carry = __umul64hi(mantissa, w[1]) + (p1 < carry);
    unsigned long long h = mantissa * w[0] + carry, l = p1;
    int q = int(h >> 62);
    h = (h << 2) | (l >> 62);
    l = (l << 2) | (p2 >> 62);
    bool negative = (long long)h < 0; // fraction >= 1/2: go to the next quadrant
    if (negative) {
        ++q;
        h = ~h;
        l = ~l + 1;
        h += l == 0;
    }
    // fraction = (h:l) * 2^-128 in quadrants.
    double fractionHi = double(h >> 11) * 0x1p-53;
    double fractionLo = double((h << 53) | (l >> 11)) * 0x1p-117;
    Pair f = fastSum(fractionHi, fractionLo);
    double hi = __dmul_rn(f.hi, 0x1.921fb54442d18p+0);
    double lo = __fma_rn(f.hi, 0x1.921fb54442d18p+0, -hi);
    lo = __fma_rn(f.hi, 0x1.1a62633145c07p-54, __fma_rn(f.lo, 0x1.921fb54442d18p+0, lo));
    Pair r = fastSum(hi, lo);
    if (negative) {
        r.hi = -r.hi;
        r.lo = -r.lo;
    }
    if (__double_as_longlong(x) < 0) {
        r.hi = -r.hi;
        r.lo = -r.lo;
        q = -q;
    }
    *quadrant = q & 3;
    return r;
}

SUNSTONE_MATH Pair reduceHalfPi(double x, int* quadrant) {
    if (!(absolute(x) < 0x1p20)) {
        if (!(absolute(x) < infinity())) {
            *quadrant = 0;
            Pair r = {quietNan(), 0};
            return r;
        }
        return reduceHuge(x, quadrant);
    }
    double n = __builtin_rint(x * 0x1.45f306dc9c883p-1);
    *quadrant = int(n) & 3;
    // n has at most 20 bits; the first part of pi/2 has 33, so the product is exact.
    double r = __fma_rn(-n, 0x1.921fb54400000p+0, x);
    double p = __dmul_rn(n, 0x1.0b4611a626331p-34);
    double e = __fma_rn(n, 0x1.0b4611a626331p-34, -p);
    double hi = __dsub_rn(r, p);
    double lo = __dsub_rn(__dsub_rn(r, hi), p) - e - n * 0x1.1701b839a2520p-88;
    Pair result = {hi, lo};
    return result;
}

SUNSTONE_DEVICE double sinKernel(double x, double lo) {
    double z = x * x;
    double p = -1.0 / 121645100408832000.0;
    p = __fma_rn(p, z, 1.0 / 355687428096000.0);
    p = __fma_rn(p, z, -1.0 / 1307674368000.0);
    p = __fma_rn(p, z, 1.0 / 6227020800.0);
    p = __fma_rn(p, z, -1.0 / 39916800.0);
    p = __fma_rn(p, z, 1.0 / 362880.0);
    p = __fma_rn(p, z, -1.0 / 5040.0);
    p = __fma_rn(p, z, 1.0 / 120.0);
    p = __fma_rn(p, z, -1.0 / 6.0);
    return __dadd_rn(x, __fma_rn(x * z, p, __fma_rn(-0.5 * z, lo, lo)));
}

SUNSTONE_DEVICE double cosKernel(double x, double lo) {
    double z = x * x;
    double p = -1.0 / 6402373705728000.0;
    p = __fma_rn(p, z, 1.0 / 20922789888000.0);
    p = __fma_rn(p, z, -1.0 / 87178291200.0);
    p = __fma_rn(p, z, 1.0 / 479001600.0);
    p = __fma_rn(p, z, -1.0 / 3628800.0);
    p = __fma_rn(p, z, 1.0 / 40320.0);
    p = __fma_rn(p, z, -1.0 / 720.0);
    p = __fma_rn(p, z, 1.0 / 24.0);
    double h = 0.5 * z;
    double w = __dsub_rn(1.0, h);
    // The rounding error of 1 - h, and that of h itself, go into the small part.
    double e = __dsub_rn(__dsub_rn(1.0, w), h) - 0.5 * __fma_rn(x, x, -z);
    return __dadd_rn(w, __fma_rn(z * z, p, __fma_rn(-x, lo, e)));
}

SUNSTONE_DEVICE void sinCosQuadrant(Pair r, int q, double* s, double* c) {
    double sine = sinKernel(r.hi, r.lo), cosine = cosKernel(r.hi, r.lo);
    double a = q & 1 ? cosine : sine, b = q & 1 ? sine : cosine;
    *s = q & 2 ? -a : a;
    *c = (q + 1) & 2 ? -b : b;
}

SUNSTONE_MATH void sinCos(double x, double* s, double* c) {
    int q;
    Pair r = reduceHalfPi(x, &q);
    sinCosQuadrant(r, q, s, c);
    if (x == 0)
        *s = x;
}
SUNSTONE_MATH double sine(double x) {
    double s, c;
    sinCos(x, &s, &c);
    return s;
}
SUNSTONE_MATH double cosine(double x) {
    double s, c;
    sinCos(x, &s, &c);
    return c;
}
SUNSTONE_MATH double tangent(double x) {
    double s, c;
    sinCos(x, &s, &c);
    return s / c;
}
// Sine and cosine of pi * x: the reduction is exact.
SUNSTONE_MATH void sinCosPi(double x, double* s, double* c) {
    if (!(absolute(x) < infinity())) {
        *s = *c = quietNan();
        return;
    }
    double n = __builtin_rint(2 * x);
    double f = __fma_rn(-0.5, n, x);
    int q = int((long long)(n - 4 * __builtin_floor(0.25 * n))) & 3;
    double hi = __dmul_rn(f, 0x1.921fb54442d18p+1);
    double lo = __fma_rn(f, 0x1.921fb54442d18p+1, -hi) + f * 0x1.1a62633145c07p-53;
    Pair r = {hi, lo};
    sinCosQuadrant(r, q, s, c);
    if (*s == 0)
        *s = withSign(0.0, x);
    if (*c == 0)
        *c = 0.0;
}

// ---- exponential and logarithm ----------------------------------------------------------------

// e^(hi + lo).
SUNSTONE_MATH double expPair(double hi, double lo) {
    if (isNan(hi))
        return hi;
    if (hi > 709.79)
        return infinity();
    if (hi < -745.14)
        return 0;
    double n = __builtin_rint(hi * 0x1.71547652b82fep+0);
    double r = __fma_rn(-n, 0x1.62e42fefa3800p-1, hi); // exact: the constant has 42 bits
    double t = __fma_rn(-n, 0x1.ef35793c76730p-45, lo);
    Pair s = fastSum(r, t);
    double x = s.hi;
    double p = 1.0 / 6227020800.0;
    p = __fma_rn(p, x, 1.0 / 479001600.0);
    p = __fma_rn(p, x, 1.0 / 39916800.0);
    p = __fma_rn(p, x, 1.0 / 3628800.0);
    p = __fma_rn(p, x, 1.0 / 362880.0);
    p = __fma_rn(p, x, 1.0 / 40320.0);
    p = __fma_rn(p, x, 1.0 / 5040.0);
    p = __fma_rn(p, x, 1.0 / 720.0);
    p = __fma_rn(p, x, 1.0 / 120.0);
    p = __fma_rn(p, x, 1.0 / 24.0);
    p = __fma_rn(p, x, 1.0 / 6.0);
    p = __fma_rn(p, x, 0.5);
    double tail = __fma_rn(x * x, p, s.lo);
    Pair one = fastSum(1.0, x);
    return scale(__dadd_rn(one.hi, tail + one.lo), int(n));
}
SUNSTONE_MATH double exponential(double x) {
    return expPair(x, 0);
}

SUNSTONE_MATH double exponential2(double x) {
    if (!(absolute(x) < 1100))
        return isNan(x) ? x : x > 0 ? infinity() : 0;
    double n = __builtin_rint(x), f = x - n;
    double hi = __dmul_rn(f, 0x1.62e42fefa39efp-1);
    double lo = __fma_rn(f, 0x1.62e42fefa39efp-1, -hi) + f * 0x1.abc9e3b39803fp-56;
    return scale(expPair(hi, lo), int(n));
}
SUNSTONE_MATH double exponential10(double x) {
    if (!(absolute(x) < 340))
        return isNan(x) ? x : x > 0 ? infinity() : 0;
    double hi = __dmul_rn(x, 0x1.26bb1bbb55516p+1);
    double lo = __fma_rn(x, 0x1.26bb1bbb55516p+1, -hi) - x * 0x1.f48ad494ea3e9p-53;
    return expPair(hi, lo);
}

// log(x) for finite x > 0, to about 65 bits; k * ln 2 is added as well.
SUNSTONE_MATH Pair logPair(double x) {
    int k = 0;
    if (x < 0x1p-1022) {
        x *= 0x1p54;
        k = -54;
    }
    unsigned long long bits = (unsigned long long)__double_as_longlong(x);
    // Mantissa into [sqrt(1/2), sqrt(2)).
    unsigned long long shifted = bits - 0x3fe6a09e667f3bcdULL;
    k += int((long long)shifted >> 52);
    double m = __longlong_as_double((long long)(bits - (shifted & 0xfff0000000000000ULL)));
    double f = m - 1.0;
    double g = m + 1.0; // rounded; its error:
    double ge = m <= 1.0 ? (1.0 - g) + m : (m - g) + 1.0;
    // s = f / (m + 1) as a pair.
    double s = __ddiv_rn(f, g);
    double se = (__fma_rn(-s, g, f) - s * ge) / g;
    double z = s * s;
    double p = 2.0 / 25;
    p = __fma_rn(p, z, 2.0 / 23);
    p = __fma_rn(p, z, 2.0 / 21);
    p = __fma_rn(p, z, 2.0 / 19);
    p = __fma_rn(p, z, 2.0 / 17);
    p = __fma_rn(p, z, 2.0 / 15);
    p = __fma_rn(p, z, 2.0 / 13);
    p = __fma_rn(p, z, 2.0 / 11);
    p = __fma_rn(p, z, 2.0 / 9);
    p = __fma_rn(p, z, 2.0 / 7);
    p = __fma_rn(p, z, 2.0 / 5);
    // The term 2 s^3 / 3 as a pair, the rest in one double.
    double ze = __fma_rn(s, s, -z) + 2 * s * se;
    double c = __dmul_rn(z, s);
    double ce = __fma_rn(z, s, -c) + ze * s + z * se;
    double t = __dmul_rn(c, 0x1.5555555555555p-1);
    double te = __fma_rn(c, 0x1.5555555555555p-1, -t) + c * 0x1.5555555555555p-55 +
                ce * 0x1.5555555555555p-1;
    Pair sum = fastSum(2 * s, t);
    double low = sum.lo + te + 2 * se + c * z * p;
    double n = double(k);
    Pair head = fastSum(n * 0x1.62e42fefa3800p-1, sum.hi);
    if (k == 0) {
        head.hi = sum.hi;
        head.lo = 0;
    }
    return fastSum(head.hi, head.lo + __fma_rn(n, 0x1.ef35793c76730p-45, low));
}

// Logarithms of 0, negative numbers, infinity and NaN; true if x is one of them.
SUNSTONE_DEVICE bool logSpecial(double x, double* result) {
    if (x > 0 && x < infinity())
        return false;
    *result = x == 0 ? -infinity() : x > 0 ? x : isNan(x) ? x : quietNan();
    return true;
}
SUNSTONE_MATH double logarithm(double x) {
    double special;
    if (logSpecial(x, &special))
        return special;
    Pair l = logPair(x);
    return l.hi + l.lo;
}
SUNSTONE_MATH double logTimes(double x, double hi, double lo) {
    double special;
    if (logSpecial(x, &special))
        return special;
    Pair l = logPair(x);
    double p = __dmul_rn(l.hi, hi);
    return p + (__fma_rn(l.hi, hi, -p) + l.lo * hi + l.hi * lo);
}
SUNSTONE_MATH double logarithm2(double x) {
    return logTimes(x, 0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56);
}
SUNSTONE_MATH double logarithm10(double x) {
    return logTimes(x, 0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57);
}
SUNSTONE_MATH double logarithm1p(double x) {
    if (absolute(x) < 0x1p-54)
        return x;
    double u = __dadd_rn(1.0, x);
    double special;
    if (logSpecial(u, &special))
        return special;
    double e = absolute(x) < 1 ? __dsub_rn(x, __dsub_rn(u, 1.0)) : __dsub_rn(1.0, __dsub_rn(u, x));
    Pair l = logPair(u);
    return l.hi + (l.lo + e / u);
}
SUNSTONE_MATH double exponentialMinus1(double x) {
    if (absolute(x) < 0x1p-54)
        return x;
    if (absolute(x) > 0.5)
        return exponential(x) - 1.0;
    double term = x, sum = 0;
    for (int i = 2; i < 18; ++i) {
        term *= x / i;
        sum += term;
    }
    return x + sum;
}

SUNSTONE_MATH double power(double x, double y) {
    if (y == 0 || x == 1)
        return 1;
    if (isNan(x) || isNan(y))
        return x + y;
    double ax = absolute(x);
    bool yInteger = absolute(y) >= 0x1p53 || __builtin_trunc(y) == y;
    bool yOdd = yInteger && absolute(y) < 0x1p53 && ((long long)y & 1);
    double sign = yOdd ? withSign(1.0, x) : 1.0;
    if (absolute(y) == infinity())
        return ax == 1 ? 1.0 : (ax > 1) == (y > 0) ? infinity() : 0.0;
    if (ax == 0)
        return sign * (y > 0 ? 0.0 : infinity());
    if (ax == infinity())
        return sign * (y > 0 ? infinity() : 0.0);
    if (x < 0 && !yInteger)
        return quietNan();
    Pair l = logPair(ax);
    double hi = __dmul_rn(l.hi, y);
    if (absolute(hi) > 800)
        return sign * (hi > 0 ? infinity() : 0.0);
    double lo = __fma_rn(l.hi, y, -hi) + l.lo * y;
    return sign * expPair(hi, lo);
}

// ---- inverse trigonometric functions ----------------------------------------------------------

// atan of x >= 0 as a pair: x = tan(a + b) with tan a = k / 8.
SUNSTONE_MATH double arcTangentPositive(double y, double x) {
    static const double table[9][2] = {{0, 0},
                                       {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                       {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                       {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                       {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                       {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                       {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                       {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                       {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}};
    bool swap = y > x;
    double a = swap ? x : y, b = swap ? y : x; // 0 <= a <= b
    double q = a / b;
    int k = int(q * 8 + 0.5);
    double c = k * 0.125;
    double t = __fma_rn(-c, b, a) / __fma_rn(c, a, b);
    double z = t * t;
    double p = -1.0 / 15;
    p = __fma_rn(p, z, 1.0 / 13);
    p = __fma_rn(p, z, -1.0 / 11);
    p = __fma_rn(p, z, 1.0 / 9);
    p = __fma_rn(p, z, -1.0 / 7);
    p = __fma_rn(p, z, 1.0 / 5);
    p = __fma_rn(p, z, -1.0 / 3);
    double low = table[k][1] + t * z * p;
    if (!swap) {
        Pair s = k ? fastSum(table[k][0], t) : Pair{t, 0};
        return s.hi + (s.lo + low);
    }
    Pair s = k ? fastSum(table[k][0], t) : Pair{t, 0};
    Pair d = fastSum(0x1.921fb54442d18p+0, -s.hi);
    return d.hi + (d.lo + 0x1.1a62633145c07p-54 - (s.lo + low));
}
SUNSTONE_MATH double arcTangent2(double y, double x) {
    const double pi = 0x1.921fb54442d18p+1;
    if (isNan(x) || isNan(y))
        return x + y;
    double ay = absolute(y), ax = absolute(x);
    bool left = __double_as_longlong(x) < 0;
    double r;
    if (ay == 0)
        r = left ? pi : 0.0;
    else if (ax == infinity() || ay == infinity())
        r = ax < ay ? pi / 2 : ax > ay ? (left ? pi : 0.0) : (left ? 3 * pi / 4 : pi / 4);
    else {
        // Scale both into a range where neither quotient nor product overflows.
        if (ax > 0x1p1000 || ay > 0x1p1000) {
            ax *= 0x1p-60;
            ay *= 0x1p-60;
        } else if (ax < 0x1p-960 && ay < 0x1p-960) {
            ax *= 0x1p60;
            ay *= 0x1p60;
        }
        r = arcTangentPositive(ay, ax);
        if (left)
            r = (pi - r) + 0x1.1a62633145c07p-53;
    }
    return withSign(r, y);
}
SUNSTONE_MATH double arcTangent(double x) {
    if (isNan(x))
        return x;
    if (absolute(x) > 0x1p60)
        return withSign(0x1.921fb54442d18p+0, x);
    return withSign(arcTangentPositive(absolute(x), 1.0), x);
}
SUNSTONE_MATH double arcSine(double x) {
    if (absolute(x) > 1)
        return quietNan();
    if (absolute(x) < 0x1p-28)
        return x;
    return withSign(arcTangent2(absolute(x), __dsqrt_rn((1 - absolute(x)) * (1 + absolute(x)))), x);
}
SUNSTONE_MATH double arcCosine(double x) {
    if (absolute(x) > 1)
        return quietNan();
    return arcTangent2(__dsqrt_rn((1 - x) * (1 + x)), x);
}

// ---- hyperbolic functions and roots -----------------------------------------------------------

SUNSTONE_MATH double hyperbolicSine(double x) {
    double a = absolute(x);
    if (a < 1) {
        double e = exponentialMinus1(a);
        return withSign(0.5 * (e + e / (e + 1)), x);
    }
    if (a > 709) {
        double e = exponential(0.5 * a);
        return withSign(0.5 * e * e, x);
    }
    double e = exponential(a);
    return withSign(0.5 * (e - 1 / e), x);
}
SUNSTONE_MATH double hyperbolicCosine(double x) {
    double a = absolute(x);
    if (a > 709) {
        double e = exponential(0.5 * a);
        return 0.5 * e * e;
    }
    double e = exponential(a);
    return 0.5 * (e + 1 / e);
}
SUNSTONE_MATH double hyperbolicTangent(double x) {
    double a = absolute(x);
    if (a > 22)
        return withSign(1.0, x);
    if (isNan(x))
        return x;
    double e = exponentialMinus1(2 * a);
    return withSign(e / (e + 2), x);
}
SUNSTONE_MATH double areaSine(double x) {
    double a = absolute(x);
    if (!(a < infinity()))
        return x;
    double r = a > 0x1p28 ? logarithm(a) + 0x1.62e42fefa39efp-1
                          : logarithm1p(a + a * a / (1 + __dsqrt_rn(a * a + 1)));
    return withSign(r, x);
}
SUNSTONE_MATH double areaCosine(double x) {
    if (x < 1)
        return quietNan();
    if (x > 0x1p28)
        return logarithm(x) + 0x1.62e42fefa39efp-1;
    double t = x - 1;
    return logarithm1p(t + __dsqrt_rn(2 * t + t * t));
}
SUNSTONE_MATH double areaTangent(double x) {
    double a = absolute(x);
    if (a > 1)
        return quietNan();
    return withSign(0.5 * logarithm1p(2 * a / (1 - a)), x);
}
SUNSTONE_MATH double cubeRoot(double x) {
    double a = absolute(x);
    if (a == 0 || !(a < infinity()))
        return x;
    double factor = 1;
    if (a < 0x1p-1000) {
        a *= 0x1p300;
        factor = 0x1p-100;
    }
    // A guess from the exponent, then Newton's method.
    double r = __longlong_as_double(__double_as_longlong(a) / 3 + 0x2a9f7893782da1ceLL);
    for (int i = 0; i < 5; ++i)
        r = r - (r * r * r - a) / (3 * r * r);
    return withSign(r * factor, x);
}
SUNSTONE_MATH double hypotenuse(double x, double y) {
    double a = absolute(x), b = absolute(y);
    if (a == infinity() || b == infinity())
        return infinity();
    if (isNan(a) || isNan(b))
        return a + b;
    double big = a > b ? a : b, small = a > b ? b : a;
    double factor = 1;
    if (big > 0x1p500) {
        big *= 0x1p-600;
        small *= 0x1p-600;
        factor = 0x1p600;
    } else if (big < 0x1p-500) {
        big *= 0x1p600;
        small *= 0x1p600;
        factor = 0x1p-600;
    }
    return factor * __dsqrt_rn(__fma_rn(big, big, small * small));
}

// ---- remainders and decomposition -------------------------------------------------------------

// x modulo y, exact: long division on the mantissas. Also gives the lowest bits of the quotient.
SUNSTONE_MATH double moduloPositive(double x, double y, unsigned int* quotient) {
    unsigned long long a = (unsigned long long)__double_as_longlong(x);
    unsigned long long b = (unsigned long long)__double_as_longlong(y);
    int ea = int(a >> 52), eb = int(b >> 52);
    unsigned long long ma = a & 0xfffffffffffffULL, mb = b & 0xfffffffffffffULL;
    if (ea)
        ma |= 1ULL << 52;
    else
        ea = 1;
    if (eb)
        mb |= 1ULL << 52;
    else
        eb = 1;
    unsigned int q = 0;
    for (; ea > eb; --ea) {
        q <<= 1;
        if (ma >= mb) {
            ma -= mb;
            q |= 1;
        }
        ma <<= 1;
    }
    q <<= 1;
    if (ea == eb && ma >= mb) {
        ma -= mb;
        q |= 1;
    }
    *quotient = q;
    // ma < 2^53 with exponent eb.
    if (ea < eb)
        return x;
    return scale(double(ma), eb - 1023 - 52);
}
SUNSTONE_MATH double modulo(double x, double y) {
    double ax = absolute(x), ay = absolute(y);
    if (!(ax < infinity()) || isNan(y) || ay == 0)
        return quietNan();
    if (ax < ay)
        return x;
    unsigned int q;
    return withSign(moduloPositive(ax, ay, &q), x);
}
SUNSTONE_MATH double remainderQuotient(double x, double y, int* quotient) {
    double ax = absolute(x), ay = absolute(y);
    *quotient = 0;
    if (!(ax < infinity()) || isNan(y) || ay == 0)
        return quietNan();
    if (ay == infinity())
        return x;
    unsigned int q = 0;
    double r = ax < ay ? ax : moduloPositive(ax, ay, &q);
    double rest = ay - r;
    if (r > rest || (r == rest && (q & 1))) {
        r = -rest;
        ++q;
    }
    bool negative = (__double_as_longlong(x) ^ __double_as_longlong(y)) < 0;
    int magnitude = int(q & 0x7fffffff);
    *quotient = negative ? -magnitude : magnitude;
    if (r == 0)
        return withSign(0.0, x);
    return __double_as_longlong(x) < 0 ? -r : r;
}
SUNSTONE_MATH double fractionExponent(double x, int* exponent) {
    *exponent = 0;
    if (x == 0 || !(absolute(x) < infinity()))
        return x;
    int extra = 0;
    if (absolute(x) < 0x1p-1022) {
        x *= 0x1p54;
        extra = -54;
    }
    long long bits = __double_as_longlong(x);
    *exponent = int((bits >> 52) & 0x7ff) - 1022 + extra;
    return __longlong_as_double((bits & ~(0x7ffLL << 52)) | (1022LL << 52));
}

// ---- error function and gamma -----------------------------------------------------------------

// exp(x * x) * erfc(x) of x >= 0.75 by its continued fraction, evaluated from a depth that suffices for
// the distance from zero: depth n leaves an error of exp(-2 x sqrt(2 n)).
SUNSTONE_MATH double erfcFraction(double x) {
    int depth = x < 1 ? 400 : x < 1.5 ? 250 : x < 3 ? 100 : 40;
    double f = 0;
    for (int k = depth; k >= 1; --k)
        f = (0.5 * k) / (x + f);
    return 0x1.20dd750429b6dp-1 / (x + f);
}
SUNSTONE_MATH double erfcTail(double x) {
    if (x > 27.3)
        return 0;
    double square = __dmul_rn(x, x), error = __fma_rn(x, x, -square);
    return expPair(-square, -error) * erfcFraction(x);
}
SUNSTONE_MATH double erfSeries(double x) {
    double z = x * x, term = x, sum = x;
    for (int n = 1; n < 40; ++n) {
        term *= -z / n;
        sum += term / (2 * n + 1);
    }
    return sum * 0x1.20dd750429b6dp+0;
}
SUNSTONE_MATH double errorFunction(double x) {
    double a = absolute(x);
    if (isNan(x))
        return x;
    return withSign(a < 1.0 ? absolute(erfSeries(a)) : 1 - erfcTail(a), x);
}
SUNSTONE_MATH double errorFunctionComplement(double x) {
    if (isNan(x))
        return x;
    return x < 0.75 ? (x < -1.0 ? 2 - erfcTail(-x) : 1 - erfSeries(x)) : erfcTail(x);
}

// The part of Stirling's series for x >= 12 that vanishes at infinity.
SUNSTONE_MATH double stirlingTail(double x) {
    double r = 1 / x, z = r * r;
    double p = 1.0 / 156;
    p = __fma_rn(p, z, -691.0 / 360360);
    p = __fma_rn(p, z, 1.0 / 1188);
    p = __fma_rn(p, z, -1.0 / 1680);
    p = __fma_rn(p, z, 1.0 / 1260);
    p = __fma_rn(p, z, -1.0 / 360);
    p = __fma_rn(p, z, 1.0 / 12);
    return p * r;
}
// log |gamma(x)| for x >= 12.
SUNSTONE_MATH double stirling(double x) {
    return (x - 0.5) * logarithm(x) - x + 0.91893853320467274178 + stirlingTail(x);
}
SUNSTONE_MATH double logGammaPositive(double x) {
    double product = 1;
    while (x < 12) {
        product *= x;
        x += 1;
    }
    return stirling(x) - logarithm(product);
}
SUNSTONE_MATH double logGamma(double x) {
    if (isNan(x))
        return x;
    if (absolute(x) == infinity())
        return infinity();
    if (x > 0)
        return x == 1 || x == 2 ? 0.0 : logGammaPositive(x);
    if (__builtin_trunc(x) == x)
        return infinity();
    double s, c;
    sinCosPi(x, &s, &c);
    return 1.1447298858494001741 - logarithm(absolute(s * x)) - logGammaPositive(-x);
}
SUNSTONE_MATH double gammaFunction(double x) {
    if (isNan(x) || x == infinity())
        return x;
    if (x == 0)
        return withSign(infinity(), x);
    if (x < 0) {
        if (__builtin_trunc(x) == x)
            return quietNan();
        if (x < -190)
            return 0;
        double s, c;
        sinCosPi(x, &s, &c);
        return 3.14159265358979323846 / (s * -x * gammaFunction(-x));
    }
    if (x > 172)
        return infinity();
    // Upwards until the series holds; whole numbers below 20 are exact products.
    double product = 1;
    if (x < 20 && __builtin_trunc(x) == x) {
        for (; x > 2; x -= 1)
            product *= x - 1;
        return product;
    }
    for (; x < 12; x += 1)
        product *= x;
    // In factors that do not overflow, each exact to about an ulp.
    double root = power(x, 0.5 * (x - 0.5));
    return root * exponential(-x) * root *
           (2.5066282746310005024 * exponential(stirlingTail(x)) / product);
}

} // namespace sunstone_math

#endif
