// SPDX-License-Identifier: Apache-2.0
// Device mathematics beyond <cmath>: Bessel functions, inverses of error functions, norms of
// vectors. Series are summed as pairs of doubles, so that cancellation costs little; float
// functions round the results of double ones.
#ifndef SUNSTONE_SPECIAL_FUNCTIONS_H
#define SUNSTONE_SPECIAL_FUNCTIONS_H

#include "math.h"

namespace sunstone_math {

SUNSTONE_MATH Pair pairSum(double a, double b) {
    const double s = __dadd_rn(a, b), part = __dsub_rn(s, a);
    return {s, __dadd_rn(__dsub_rn(a, __dsub_rn(s, part)), __dsub_rn(b, part))};
}
SUNSTONE_MATH Pair pairAdd(Pair a, Pair b) {
    const Pair s = pairSum(a.hi, b.hi);
    return pairSum(s.hi, s.lo + (a.lo + b.lo));
}
SUNSTONE_MATH Pair pairTimes(Pair a, Pair b) {
    const double p = __dmul_rn(a.hi, b.hi);
    return pairSum(p, __fma_rn(a.hi, b.hi, -p) + (a.hi * b.lo + a.lo * b.hi));
}
SUNSTONE_MATH Pair pairOver(Pair a, double b) {
    const double q = __ddiv_rn(a.hi, b);
    return pairSum(q, (__fma_rn(-q, b, a.hi) + a.lo) / b);
}
SUNSTONE_MATH Pair squareQuarter(double x, double sign) { // sign * x * x / 4
    const double p = __dmul_rn(x, x);
    return {sign * 0.25 * p, sign * 0.25 * __fma_rn(x, x, -p)};
}

// The sum of q^k / (k! (k + order)!) for order 0 or 1. `weighted`, if given, receives the same sum
// with each term times H(k) + H(k + order), where H(n) is the sum of 1/i up to n.
SUNSTONE_MATH Pair besselSeries(Pair q, int order, Pair* weighted) {
    Pair term = {1, 0}, sum = term, harmonic = {(double)order, 0}, other = harmonic;
    for (int k = 1; k < 400; ++k) {
        term = pairOver(pairTimes(term, q), (double)k * (k + order));
        sum = pairAdd(sum, term);
        if (weighted) {
            const Pair one = {1, 0};
            harmonic = pairAdd(harmonic, pairAdd(pairOver(one, k), pairOver(one, k + order)));
            other = pairAdd(other, pairTimes(term, harmonic));
        }
        if (absolute(term.hi) * k < 1e-34 * absolute(sum.hi) || absolute(term.hi) < 1e-40)
            break;
    }
    if (weighted)
        *weighted = other;
    return sum;
}

// Hankel's expansion for x >= 25: of J if not `second`, of Y otherwise.
SUNSTONE_MATH double besselFar(double x, int order, bool second) {
    const double mu = 4.0 * order * order, r = 1 / (8 * x);
    double term = 1, p = 1, q = 0;
    for (int k = 1; k < 30; ++k) {
        const double odd = 2 * k - 1;
        term *= (mu - odd * odd) * r / k;
        if (k & 1)
            q += (k & 2) ? -term : term;
        else
            p += (k & 2) ? -term : term;
        if (absolute(term) < 1e-18)
            break;
    }
    double s, c;
    sinCos(x, &s, &c);
    // The angle minus pi/4, and another pi/2 less for order 1.
    double cosine = (c + s) * 0x1.6a09e667f3bcdp-1, sine = (s - c) * 0x1.6a09e667f3bcdp-1;
    if (order == 1) {
        const double turned = cosine;
        cosine = sine;
        sine = -turned;
    }
    const double size = __dsqrt_rn(0x1.45f306dc9c883p-1 / x);
    return size * (second ? p * sine + q * cosine : p * cosine - q * sine);
}

SUNSTONE_MATH double besselJ(double x, int order) {
    const double a = absolute(x);
    if (isNan(x))
        return x;
    if (a == infinity())
        return 0;
    double value = 0;
    if (a >= 25) {
        value = besselFar(a, order, false);
    } else {
        const Pair sum = besselSeries(squareQuarter(a, -1), order, nullptr);
        value = order == 0 ? sum.hi : 0.5 * a * sum.hi;
    }
    return order == 1 && x < 0 ? -value : value;
}
SUNSTONE_MATH double besselY(double x, int order) {
    if (isNan(x) || x < 0)
        return quietNan();
    if (x == 0)
        return -infinity();
    if (x == infinity())
        return 0;
    if (x >= 25)
        return besselFar(x, order, true);
    const Pair gamma = {0x1.2788cfc6fb619p-1, -0x1.6cb90701fbfabp-58};
    Pair weighted;
    const Pair sum = besselSeries(squareQuarter(x, -1), order, &weighted);
    // log(x/2) + gamma, twice
    const Pair logarithmOfHalf = logPair(0.5 * x);
    const Pair twice = pairAdd(pairAdd(logarithmOfHalf, gamma), pairAdd(logarithmOfHalf, gamma));
    const Pair difference =
        pairAdd(pairTimes(twice, sum), Pair{-weighted.hi, -weighted.lo});
    if (order == 0)
        return 0x1.45f306dc9c883p-2 * difference.hi;
    const Pair half = {0.5 * x, 0}, two = {-2, 0};
    return 0x1.45f306dc9c883p-2 * pairAdd(pairTimes(half, difference), pairOver(two, x)).hi;
}
SUNSTONE_MATH double besselJ(int n, double x) {
    if (n < 0 || isNan(x))
        return quietNan();
    if (n < 2)
        return besselJ(x, n);
    const double a = absolute(x);
    if (a == 0 || a == infinity())
        return 0;
    double value = 0;
    if (a > n) {
        double before = besselJ(a, 0), here = besselJ(a, 1);
        for (int k = 1; k < n; ++k) {
            const double next = 2.0 * k / a * here - before;
            before = here;
            here = next;
        }
        value = here;
    } else {
        // Downwards from an order where it is negligible; the sum J0 + 2 J2 + 2 J4 + ... is 1.
        double after = 0, here = 1e-300, sum = 0;
        for (int k = 2 * ((n + 20 + (int)__dsqrt_rn(60.0 * n)) / 2); k > 0; --k) {
            const double before = 2.0 * k / a * here - after;
            after = here;
            here = before;
            if (absolute(here) > 1e250) {
                here *= 1e-250;
                after *= 1e-250;
                sum *= 1e-250;
                value *= 1e-250;
            }
            if (k - 1 == n)
                value = here;
            if ((k & 1) && k > 1)
                sum += 2 * here;
        }
        value /= sum + here;
    }
    return x < 0 && (n & 1) ? -value : value;
}
SUNSTONE_MATH double besselY(int n, double x) {
    if (n < 0)
        return quietNan();
    if (n < 2)
        return besselY(x, n);
    double before = besselY(x, 0), here = besselY(x, 1);
    for (int k = 1; k < n && here > -infinity(); ++k) {
        const double next = 2.0 * k / x * here - before;
        before = here;
        here = next;
    }
    return here;
}
SUNSTONE_MATH double besselI(double x, int order) {
    const double a = absolute(x);
    if (isNan(x))
        return x;
    double value = 0;
    if (a < 30) {
        value = besselSeries(squareQuarter(a, 1), order, nullptr).hi;
        if (order == 1)
            value *= 0.5 * a;
    } else {
        const double mu = 4.0 * order * order, r = 1 / (8 * a);
        double term = 1, sum = 1;
        for (int k = 1; k < 40 && absolute(term) > 1e-18; ++k) {
            const double odd = 2 * k - 1;
            term *= (odd * odd - mu) * r / k;
            sum += term;
        }
        const double root = exponential(0.5 * a); // its square may be too large
        value = root * (root * (sum * __dsqrt_rn(0x1.45f306dc9c883p-3 / a)));
    }
    return order == 1 && x < 0 ? -value : value;
}

// exp(x * x) * erfc(x)
SUNSTONE_MATH double scaledErrorFunctionComplement(double x) {
    if (x >= 0.75)
        return x == infinity() ? 0 : erfcFraction(x);
    const double square = __dmul_rn(x, x);
    return x < -27 ? infinity() : expPair(square, __fma_rn(x, x, -square)) * errorFunctionComplement(x);
}

// y with erfc(y) = c, for c from 0 to 1/4, and y with erf(y) = x, for |x| up to 3/4: an initial
// value, improved by Halley's method.
SUNSTONE_MATH double inverseTail(double c) {
    const double t = __dsqrt_rn(-2 * logarithm(0.5 * c));
    double y = (t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                        (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)))) *
               0x1.6a09e667f3bcdp-1;
    for (int i = 0; i < 2; ++i) {
        const double error = errorFunctionComplement(y);
        // The derivative through erfcx, to avoid underflow.
        const double u = (c / error - 1) * scaledErrorFunctionComplement(y) * 0x1.c5bf891b4ef6bp-1;
        y -= u / (1 + u * y);
    }
    return y;
}
SUNSTONE_MATH Pair erfPair(double x) { // |x| < 1
    const double square = __dmul_rn(x, x);
    const Pair z = {-square, -__fma_rn(x, x, -square)}, start = {x, 0};
    Pair term = start, sum = start;
    for (int n = 1; n < 40; ++n) {
        term = pairOver(pairTimes(term, z), n);
        sum = pairAdd(sum, pairOver(term, 2 * n + 1));
    }
    return pairTimes(sum, Pair{0x1.20dd750429b6dp+0, 0x1.1ae3a914fed80p-56});
}
SUNSTONE_MATH double inverseCentre(Pair x) {
    const double a = x.hi, z = a * a;
    double y = a * (0x1.c5bf891b4ef6bp-1 * (1 + z * (0.2618 + z * (0.1439 + z * 0.0977))));
    for (int i = 0; i < 3; ++i) {
        const double u = (errorFunction(y) - a) * exponential(y * y) * 0x1.c5bf891b4ef6bp-1;
        y -= u / (1 + u * y);
    }
    const double rest = pairAdd(erfPair(y), Pair{-x.hi, -x.lo}).hi;
    return y - rest * exponential(y * y) * 0x1.c5bf891b4ef6bp-1;
}
SUNSTONE_MATH double inverseErrorFunction(double x) {
    const double a = absolute(x);
    if (!(a <= 1))
        return quietNan();
    if (a == 1)
        return withSign(infinity(), x);
    return a <= 0.75 ? inverseCentre(Pair{x, 0}) : withSign(inverseTail(1 - a), x);
}
SUNSTONE_MATH double inverseErrorFunctionComplement(double x) {
    if (!(x >= 0 && x <= 2))
        return quietNan();
    if (x == 0 || x == 2)
        return x == 0 ? infinity() : -infinity();
    return x < 0.25 ? inverseTail(x) : x > 1.75 ? -inverseTail(2 - x) : inverseCentre(pairSum(1, -x));
}

} // namespace sunstone_math

#define SUNSTONE_SPECIAL(name, result)                                                             \
    SUNSTONE_DEVICE double name(double x) { return sunstone_math::result; }                        \
    SUNSTONE_DEVICE float name##f(float x) { return (float)sunstone_math::result; }
SUNSTONE_SPECIAL(j0, besselJ((double)x, 0))
SUNSTONE_SPECIAL(j1, besselJ((double)x, 1))
SUNSTONE_SPECIAL(y0, besselY((double)x, 0))
SUNSTONE_SPECIAL(y1, besselY((double)x, 1))
SUNSTONE_SPECIAL(cyl_bessel_i0, besselI((double)x, 0))
SUNSTONE_SPECIAL(cyl_bessel_i1, besselI((double)x, 1))
SUNSTONE_SPECIAL(erfcx, scaledErrorFunctionComplement(x))
SUNSTONE_SPECIAL(erfinv, inverseErrorFunction(x))
SUNSTONE_SPECIAL(erfcinv, inverseErrorFunctionComplement(x))
SUNSTONE_SPECIAL(normcdfinv, inverseErrorFunctionComplement(2.0 * x) * -0x1.6a09e667f3bcdp+0)
#undef SUNSTONE_SPECIAL
SUNSTONE_DEVICE double jn(int n, double x) { return sunstone_math::besselJ(n, x); }
SUNSTONE_DEVICE float jnf(int n, float x) { return (float)sunstone_math::besselJ(n, (double)x); }
SUNSTONE_DEVICE double yn(int n, double x) { return sunstone_math::besselY(n, x); }
SUNSTONE_DEVICE float ynf(int n, float x) { return (float)sunstone_math::besselY(n, (double)x); }

// ---- lengths of vectors -------------------------------------------------------------------------------
namespace sunstone_math {
// The length of a vector, or its reciprocal: squares scaled and summed with two doubles.
template <class T>
SUNSTONE_MATH double lengthOf(const T* p, int count, bool reciprocal) {
    double largest = 0;
    bool nan = false;
    for (int i = 0; i < count; ++i) {
        const double a = absolute((double)p[i]);
        nan |= isNan(a);
        largest = a > largest ? a : largest;
    }
    if (largest == infinity())
        return reciprocal ? 0 : largest;
    if (nan)
        return quietNan();
    if (largest == 0)
        return reciprocal ? infinity() : 0;
    int exponent = 0;
    fractionExponent(largest, &exponent);
    Pair sum = {0, 0};
    for (int i = 0; i < count; ++i) {
        const double x = scale((double)p[i], -exponent), square = __dmul_rn(x, x);
        sum = pairAdd(sum, Pair{square, __fma_rn(x, x, -square)});
    }
    const double root = __dsqrt_rn(sum.hi);
    const double rest = (__fma_rn(-root, root, sum.hi) + sum.lo) / (2 * root);
    if (!reciprocal)
        return scale(root + rest, exponent);
    const double inverse = __ddiv_rn(1, root);
    return scale(inverse + inverse * (__fma_rn(-inverse, root, 1.0) - inverse * rest), -exponent);
}
} // namespace sunstone_math
SUNSTONE_DEVICE double norm(int count, const double* p) {
    return sunstone_math::lengthOf(p, count, false);
}
SUNSTONE_DEVICE float normf(int count, const float* p) {
    return (float)sunstone_math::lengthOf(p, count, false);
}
SUNSTONE_DEVICE double rnorm(int count, const double* p) {
    return sunstone_math::lengthOf(p, count, true);
}
SUNSTONE_DEVICE float rnormf(int count, const float* p) {
    return (float)sunstone_math::lengthOf(p, count, true);
}
SUNSTONE_DEVICE double norm3d(double x, double y, double z) {
    const double p[] = {x, y, z};
    return norm(3, p);
}
SUNSTONE_DEVICE double norm4d(double x, double y, double z, double w) {
    const double p[] = {x, y, z, w};
    return norm(4, p);
}
SUNSTONE_DEVICE double rnorm3d(double x, double y, double z) {
    const double p[] = {x, y, z};
    return rnorm(3, p);
}
SUNSTONE_DEVICE double rnorm4d(double x, double y, double z, double w) {
    const double p[] = {x, y, z, w};
    return rnorm(4, p);
}
SUNSTONE_DEVICE float norm3df(float x, float y, float z) {
    return (float)norm3d((double)x, (double)y, (double)z);
}
SUNSTONE_DEVICE float norm4df(float x, float y, float z, float w) {
    return (float)norm4d((double)x, (double)y, (double)z, (double)w);
}
SUNSTONE_DEVICE float rnorm3df(float x, float y, float z) {
    return (float)rnorm3d((double)x, (double)y, (double)z);
}
SUNSTONE_DEVICE float rnorm4df(float x, float y, float z, float w) {
    return (float)rnorm4d((double)x, (double)y, (double)z, (double)w);
}

// ---- further names for functions of other headers ----------------------------------------------
SUNSTONE_DEVICE double scalbln(double x, long n) {
    return ldexp(x, n > 100000 ? 100000 : n < -100000 ? -100000 : (int)n);
}
SUNSTONE_DEVICE float scalblnf(float x, long n) {
    return ldexpf(x, n > 100000 ? 100000 : n < -100000 ? -100000 : (int)n);
}
SUNSTONE_DEVICE float scalbln(float x, long n) { return scalblnf(x, n); }
SUNSTONE_DEVICE unsigned int umin(unsigned int a, unsigned int b) { return a < b ? a : b; }
SUNSTONE_DEVICE unsigned int umax(unsigned int a, unsigned int b) { return a > b ? a : b; }
SUNSTONE_DEVICE long long llmin(long long a, long long b) { return a < b ? a : b; }
SUNSTONE_DEVICE long long llmax(long long a, long long b) { return a > b ? a : b; }
SUNSTONE_DEVICE unsigned long long ullmin(unsigned long long a, unsigned long long b) {
    return a < b ? a : b;
}
SUNSTONE_DEVICE unsigned long long ullmax(unsigned long long a, unsigned long long b) {
    return a > b ? a : b;
}
// The position of the n-th set bit from `from` on, upwards or, for n < 0, downwards.
SUNSTONE_DEVICE unsigned int __fns(unsigned int mask, unsigned int from, int n) {
    unsigned int r;
    asm("fns.b32 %0, %1, %2, %3;" : "=r"(r) : "r"(mask), "r"(from), "r"(n));
    return r;
}

#endif
