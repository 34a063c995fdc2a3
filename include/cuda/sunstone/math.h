// SPDX-License-Identifier: Apache-2.0
// CUDA's mathematical functions for device code, with overloads for float, double and integers like
// those of <cmath>, also in namespace std. Include before <cmath>: the standard library's constexpr
// functions stay host functions only if a device function already exists. With
// -fgpu-approx-transcendentals sinf, cosf, expf, ... are the fast approximations.
#ifndef SUNSTONE_MATH_H
#define SUNSTONE_MATH_H

#include "float_kernels.h"
#include "math_kernels.h"

// ---- one instruction each ---------------------------------------------------------------------
#define SUNSTONE_UNARY(name, inF, inD)                                                             \
    SUNSTONE_DEVICE float name##f(float x) { return inF; }                                         \
    SUNSTONE_DEVICE double name(double x) { return inD; }                                          \
    SUNSTONE_DEVICE float name(float x) { return name##f(x); }
#define SUNSTONE_BINARY(name, inF, inD)                                                            \
    SUNSTONE_DEVICE float name##f(float x, float y) { return inF; }                                \
    SUNSTONE_DEVICE double name(double x, double y) { return inD; }                                \
    SUNSTONE_DEVICE float name(float x, float y) { return name##f(x, y); }

SUNSTONE_UNARY(fabs, __builtin_fabsf(x), __builtin_fabs(x))
SUNSTONE_UNARY(floor, __builtin_floorf(x), __builtin_floor(x))
SUNSTONE_UNARY(ceil, __builtin_ceilf(x), __builtin_ceil(x))
SUNSTONE_UNARY(trunc, __builtin_truncf(x), __builtin_trunc(x))
SUNSTONE_UNARY(rint, __builtin_rintf(x), __builtin_rint(x))
SUNSTONE_UNARY(nearbyint, __builtin_rintf(x), __builtin_rint(x))
SUNSTONE_UNARY(sqrt, __builtin_sqrtf(x), __dsqrt_rn(x))
SUNSTONE_UNARY(rsqrt, __nvvm_rsqrt_approx_f(x), 1.0 / __dsqrt_rn(x))
SUNSTONE_UNARY(round, __builtin_copysignf(__builtin_truncf(__builtin_fabsf(x) + 0.49999997f), x),
               __builtin_copysign(__builtin_trunc(__builtin_fabs(x) + 0.49999999999999994), x))
SUNSTONE_BINARY(fmin, __nvvm_fmin_f(x, y), __nvvm_fmin_d(x, y))
SUNSTONE_BINARY(fmax, __nvvm_fmax_f(x, y), __nvvm_fmax_d(x, y))
SUNSTONE_BINARY(copysign, __builtin_copysignf(x, y), __builtin_copysign(x, y))
SUNSTONE_BINARY(fdim, x <= y ? 0.0f : x - y, x <= y ? 0.0 : x - y)
SUNSTONE_DEVICE float fmaf(float x, float y, float z) { return __builtin_fmaf(x, y, z); }
SUNSTONE_DEVICE double fma(double x, double y, double z) { return __builtin_fma(x, y, z); }
SUNSTONE_DEVICE float fma(float x, float y, float z) { return __builtin_fmaf(x, y, z); }
SUNSTONE_DEVICE float saturate(float x) { return __saturatef(x); }
SUNSTONE_DEVICE float fdividef(float x, float y) { return x / y; }

// ---- elementary functions ---------------------------------------------------------------------
#define SUNSTONE_ELEMENTARY(name, kernel)                                                          \
    SUNSTONE_UNARY(name, (float)sunstone_math::kernel(x), sunstone_math::kernel(x))
#if defined(__CLANG_GPU_APPROX_TRANSCENDENTALS__) || defined(__CLANG_CUDA_APPROX_TRANSCENDENTALS__)
#define SUNSTONE_FAST(name, fast, kernel) SUNSTONE_UNARY(name, fast(x), sunstone_math::kernel(x))
#else
#define SUNSTONE_FAST(name, fast, kernel) SUNSTONE_ELEMENTARY(name, kernel)
#endif
SUNSTONE_FAST(sin, __sinf, sine)
SUNSTONE_FAST(cos, __cosf, cosine)
SUNSTONE_FAST(tan, __tanf, tangent)
SUNSTONE_FAST(exp, __expf, exponential)
SUNSTONE_FAST(exp2, sunstoneExp2Approx, exponential2)
SUNSTONE_FAST(exp10, __exp10f, exponential10)
SUNSTONE_FAST(log, __logf, logarithm)
SUNSTONE_FAST(log2, __log2f, logarithm2)
SUNSTONE_FAST(log10, __log10f, logarithm10)
SUNSTONE_ELEMENTARY(expm1, exponentialMinus1)
SUNSTONE_ELEMENTARY(log1p, logarithm1p)
SUNSTONE_ELEMENTARY(asin, arcSine)
SUNSTONE_ELEMENTARY(acos, arcCosine)
SUNSTONE_ELEMENTARY(atan, arcTangent)
SUNSTONE_ELEMENTARY(sinh, hyperbolicSine)
SUNSTONE_ELEMENTARY(cosh, hyperbolicCosine)
SUNSTONE_ELEMENTARY(tanh, hyperbolicTangent)
SUNSTONE_ELEMENTARY(asinh, areaSine)
SUNSTONE_ELEMENTARY(acosh, areaCosine)
SUNSTONE_ELEMENTARY(atanh, areaTangent)
SUNSTONE_ELEMENTARY(cbrt, cubeRoot)
SUNSTONE_ELEMENTARY(erf, errorFunction)
SUNSTONE_ELEMENTARY(erfc, errorFunctionComplement)
SUNSTONE_ELEMENTARY(tgamma, gammaFunction)
SUNSTONE_ELEMENTARY(lgamma, logGamma)
SUNSTONE_UNARY(rcbrt, (float)(1.0 / sunstone_math::cubeRoot(x)), 1.0 / sunstone_math::cubeRoot(x))
#if defined(__CLANG_GPU_APPROX_TRANSCENDENTALS__) || defined(__CLANG_CUDA_APPROX_TRANSCENDENTALS__)
SUNSTONE_BINARY(pow, __powf(x, y), sunstone_math::power(x, y))
#else
SUNSTONE_BINARY(pow, (float)sunstone_math::power(x, y), sunstone_math::power(x, y))
#endif
SUNSTONE_BINARY(atan2, (float)sunstone_math::arcTangent2(x, y), sunstone_math::arcTangent2(x, y))
SUNSTONE_BINARY(hypot, (float)sunstone_math::hypotenuse(x, y), sunstone_math::hypotenuse(x, y))
SUNSTONE_BINARY(rhypot, 1.0f / sunstone_math::hypotenuse(x, y),
                1.0 / sunstone_math::hypotenuse(x, y))
SUNSTONE_BINARY(fmod, (float)sunstone_math::modulo(x, y), sunstone_math::modulo(x, y))
SUNSTONE_DEVICE double pow(double x, int y) { return sunstone_math::power(x, y); }
SUNSTONE_DEVICE float pow(float x, int y) { return powf(x, (float)y); }

SUNSTONE_DEVICE void sincosf(float x, float* s, float* c) {
#if defined(__CLANG_GPU_APPROX_TRANSCENDENTALS__) || defined(__CLANG_CUDA_APPROX_TRANSCENDENTALS__)
    __sincosf(x, s, c);
#else
    sunstone_math::sinCos(x, s, c);
#endif
}
SUNSTONE_DEVICE void sincos(double x, double* s, double* c) { sunstone_math::sinCos(x, s, c); }
SUNSTONE_DEVICE void sincos(float x, float* s, float* c) { sincosf(x, s, c); }
SUNSTONE_DEVICE void sincospi(double x, double* s, double* c) { sunstone_math::sinCosPi(x, s, c); }
SUNSTONE_DEVICE void sincospif(float x, float* s, float* c) {
    sunstone_math::sinCosPi(x, s, c);
}
#define SUNSTONE_OF_PI(T, sine, cosine)                                                            \
    SUNSTONE_DEVICE T sine(T x) {                                                                  \
        T s, c;                                                                                    \
        sunstone_math::sinCosPi(x, &s, &c);                                                        \
        return s;                                                                                  \
    }                                                                                              \
    SUNSTONE_DEVICE T cosine(T x) {                                                                \
        T s, c;                                                                                    \
        sunstone_math::sinCosPi(x, &s, &c);                                                        \
        return c;                                                                                  \
    }
SUNSTONE_OF_PI(double, sinpi, cospi)
SUNSTONE_OF_PI(float, sinpif, cospif)
#undef SUNSTONE_OF_PI
SUNSTONE_DEVICE float normcdff(float x) {
    return (float)(0.5 * sunstone_math::errorFunctionComplement(-0.70710678118654752440 * x));
}
SUNSTONE_DEVICE double normcdf(double x) {
    return 0.5 * sunstone_math::errorFunctionComplement(-0.70710678118654752440 * x);
}

// ---- rounding to integers, parts of numbers ---------------------------------------------------
SUNSTONE_DEVICE long lrint(double x) { return __double2ll_rn(x); }
SUNSTONE_DEVICE long lrintf(float x) { return __float2ll_rn(x); }
SUNSTONE_DEVICE long lrint(float x) { return lrintf(x); }
SUNSTONE_DEVICE long long llrint(double x) { return __double2ll_rn(x); }
SUNSTONE_DEVICE long long llrintf(float x) { return __float2ll_rn(x); }
SUNSTONE_DEVICE long long llrint(float x) { return llrintf(x); }
SUNSTONE_DEVICE long lround(double x) { return __double2ll_rz(round(x)); }
SUNSTONE_DEVICE long lroundf(float x) { return __float2ll_rz(roundf(x)); }
SUNSTONE_DEVICE long lround(float x) { return lroundf(x); }
SUNSTONE_DEVICE long long llround(double x) { return __double2ll_rz(round(x)); }
SUNSTONE_DEVICE long long llroundf(float x) { return __float2ll_rz(roundf(x)); }
SUNSTONE_DEVICE long long llround(float x) { return llroundf(x); }
SUNSTONE_DEVICE double remquo(double x, double y, int* q) {
    return sunstone_math::remainderQuotient(x, y, q);
}
SUNSTONE_DEVICE float remquof(float x, float y, int* q) {
    return (float)sunstone_math::remainderQuotient(x, y, q);
}
SUNSTONE_DEVICE double remainder(double x, double y) {
    int q;
    return sunstone_math::remainderQuotient(x, y, &q);
}
SUNSTONE_DEVICE float remainderf(float x, float y) { return (float)remainder((double)x, (double)y); }
SUNSTONE_DEVICE float remainder(float x, float y) { return remainderf(x, y); }
SUNSTONE_DEVICE double frexp(double x, int* e) { return sunstone_math::fractionExponent(x, e); }
SUNSTONE_DEVICE float frexpf(float x, int* e) {
    return (float)sunstone_math::fractionExponent(x, e);
}
SUNSTONE_DEVICE float frexp(float x, int* e) { return frexpf(x, e); }
SUNSTONE_DEVICE double ldexp(double x, int n) { return sunstone_math::scale(x, n); }
SUNSTONE_DEVICE float ldexpf(float x, int n) {
    return (float)sunstone_math::scale(x, n < -400 ? -400 : n > 400 ? 400 : n);
}
SUNSTONE_DEVICE float ldexp(float x, int n) { return ldexpf(x, n); }
SUNSTONE_DEVICE double scalbn(double x, int n) { return ldexp(x, n); }
SUNSTONE_DEVICE float scalbnf(float x, int n) { return ldexpf(x, n); }
SUNSTONE_DEVICE float scalbn(float x, int n) { return ldexpf(x, n); }
SUNSTONE_DEVICE double modf(double x, double* whole) {
    *whole = trunc(x);
    return copysign(fabs(x) == sunstone_math::infinity() ? 0.0 : x - *whole, x);
}
SUNSTONE_DEVICE float modff(float x, float* whole) {
    *whole = truncf(x);
    return copysignf(__float_as_int(fabsf(x)) == 0x7f800000 ? 0.0f : x - *whole, x);
}
SUNSTONE_DEVICE float modf(float x, float* whole) { return modff(x, whole); }
SUNSTONE_DEVICE int ilogb(double x) {
    if (x == 0 || x != x)
        return -2147483647 - 1;
    if (fabs(x) == sunstone_math::infinity())
        return 2147483647;
    int e;
    sunstone_math::fractionExponent(x, &e);
    return e - 1;
}
SUNSTONE_DEVICE int ilogbf(float x) { return ilogb((double)x); }
SUNSTONE_DEVICE int ilogb(float x) { return ilogb((double)x); }
SUNSTONE_DEVICE double logb(double x) {
    return x == 0 ? -sunstone_math::infinity() : x != x || fabs(x) == sunstone_math::infinity()
               ? x * x : (double)ilogb(x);
}
SUNSTONE_DEVICE float logbf(float x) { return (float)logb((double)x); }
SUNSTONE_DEVICE float logb(float x) { return logbf(x); }
SUNSTONE_DEVICE float nextafterf(float x, float y) {
    if (x != x || y != y)
        return x + y;
    if (x == y)
        return y;
    int i = __float_as_int(x);
    if (x == 0)
        return copysignf(__int_as_float(1), y);
    return __int_as_float((x < y) == (i > 0) ? i + 1 : i - 1);
}
SUNSTONE_DEVICE double nextafter(double x, double y) {
    if (x != x || y != y)
        return x + y;
    if (x == y)
        return y;
    long long i = __double_as_longlong(x);
    if (x == 0)
        return copysign(__longlong_as_double(1), y);
    return __longlong_as_double((x < y) == (i > 0) ? i + 1 : i - 1);
}
SUNSTONE_DEVICE float nextafter(float x, float y) { return nextafterf(x, y); }
SUNSTONE_DEVICE float nanf(const char*) { return __int_as_float(0x7fffffff); }
SUNSTONE_DEVICE double nan(const char*) { return sunstone_math::quietNan(); }
SUNSTONE_DEVICE int __isnanf(float x) { return __builtin_isnan(x); }
SUNSTONE_DEVICE int __isinff(float x) { return __builtin_isinf(x); }
SUNSTONE_DEVICE int __finitef(float x) { return __builtin_isfinite(x); }
SUNSTONE_DEVICE int __signbitf(float x) { return __builtin_signbitf(x); }

// ---- integers ---------------------------------------------------------------------------------
SUNSTONE_DEVICE int abs(int x) { return x < 0 ? -x : x; }
SUNSTONE_DEVICE long labs(long x) { return x < 0 ? -x : x; }
SUNSTONE_DEVICE long long llabs(long long x) { return x < 0 ? -x : x; }
SUNSTONE_DEVICE long abs(long x) { return labs(x); }
SUNSTONE_DEVICE long long abs(long long x) { return llabs(x); }
SUNSTONE_DEVICE float abs(float x) { return fabsf(x); }
SUNSTONE_DEVICE double abs(double x) { return fabs(x); }

// Calls such as sqrt(2): integers count as double.
#define SUNSTONE_INTEGER_ARGUMENT(name)                                                            \
    template <class T>                                                                             \
    SUNSTONE_DEVICE typename sunstone_math::IfInteger<T>::type name(T x) {                         \
        return name((double)x);                                                                    \
    }
namespace sunstone_math {
template <class T>
struct IfInteger {};
#define SUNSTONE_INTEGER(T)                                                                        \
    template <>                                                                                    \
    struct IfInteger<T> {                                                                          \
        typedef double type;                                                                       \
    };
SUNSTONE_INTEGER(int)
SUNSTONE_INTEGER(unsigned int)
SUNSTONE_INTEGER(long)
SUNSTONE_INTEGER(unsigned long)
SUNSTONE_INTEGER(long long)
SUNSTONE_INTEGER(unsigned long long)
SUNSTONE_INTEGER(short)
SUNSTONE_INTEGER(unsigned short)
SUNSTONE_INTEGER(char)
SUNSTONE_INTEGER(signed char)
SUNSTONE_INTEGER(unsigned char)
#undef SUNSTONE_INTEGER
// The type of <cmath>'s results for two different arithmetic types.
template <class A, class B>
struct Mixed {
    typedef double type;
};
template <class A>
struct Mixed<A, A> {}; // same type: the plain overloads, or nothing
} // namespace sunstone_math
SUNSTONE_INTEGER_ARGUMENT(fabs)
SUNSTONE_INTEGER_ARGUMENT(floor)
SUNSTONE_INTEGER_ARGUMENT(ceil)
SUNSTONE_INTEGER_ARGUMENT(trunc)
SUNSTONE_INTEGER_ARGUMENT(rint)
SUNSTONE_INTEGER_ARGUMENT(round)
SUNSTONE_INTEGER_ARGUMENT(sqrt)
SUNSTONE_INTEGER_ARGUMENT(rsqrt)
SUNSTONE_INTEGER_ARGUMENT(sin)
SUNSTONE_INTEGER_ARGUMENT(cos)
SUNSTONE_INTEGER_ARGUMENT(tan)
SUNSTONE_INTEGER_ARGUMENT(exp)
SUNSTONE_INTEGER_ARGUMENT(exp2)
SUNSTONE_INTEGER_ARGUMENT(log)
SUNSTONE_INTEGER_ARGUMENT(log2)
SUNSTONE_INTEGER_ARGUMENT(log10)
SUNSTONE_INTEGER_ARGUMENT(expm1)
SUNSTONE_INTEGER_ARGUMENT(log1p)
SUNSTONE_INTEGER_ARGUMENT(asin)
SUNSTONE_INTEGER_ARGUMENT(acos)
SUNSTONE_INTEGER_ARGUMENT(atan)
SUNSTONE_INTEGER_ARGUMENT(sinh)
SUNSTONE_INTEGER_ARGUMENT(cosh)
SUNSTONE_INTEGER_ARGUMENT(tanh)
SUNSTONE_INTEGER_ARGUMENT(asinh)
SUNSTONE_INTEGER_ARGUMENT(acosh)
SUNSTONE_INTEGER_ARGUMENT(atanh)
SUNSTONE_INTEGER_ARGUMENT(cbrt)
SUNSTONE_INTEGER_ARGUMENT(erf)
SUNSTONE_INTEGER_ARGUMENT(erfc)
SUNSTONE_INTEGER_ARGUMENT(tgamma)
SUNSTONE_INTEGER_ARGUMENT(lgamma)
#define SUNSTONE_MIXED_ARGUMENTS(name)                                                             \
    template <class A, class B>                                                                    \
    SUNSTONE_DEVICE typename sunstone_math::Mixed<A, B>::type name(A x, B y) {                     \
        return name((double)x, (double)y);                                                         \
    }                                                                                              \
    template <class A>                                                                             \
    SUNSTONE_DEVICE typename sunstone_math::IfInteger<A>::type name(A x, A y) {                    \
        return name((double)x, (double)y);                                                         \
    }
SUNSTONE_MIXED_ARGUMENTS(fmin)
SUNSTONE_MIXED_ARGUMENTS(fmax)
SUNSTONE_MIXED_ARGUMENTS(copysign)
SUNSTONE_MIXED_ARGUMENTS(fdim)
SUNSTONE_MIXED_ARGUMENTS(pow)
SUNSTONE_MIXED_ARGUMENTS(atan2)
SUNSTONE_MIXED_ARGUMENTS(hypot)
SUNSTONE_MIXED_ARGUMENTS(fmod)
SUNSTONE_MIXED_ARGUMENTS(remainder)
SUNSTONE_MIXED_ARGUMENTS(nextafter)

#undef SUNSTONE_INTEGER_ARGUMENT
#undef SUNSTONE_MIXED_ARGUMENTS
#undef SUNSTONE_UNARY
#undef SUNSTONE_BINARY
#undef SUNSTONE_ELEMENTARY
#undef SUNSTONE_FAST

// The smaller and the larger of two, for host and device. If one argument is NaN, the result is the
// other one.
#define SUNSTONE_MINMAX(T)                                                                         \
    static __inline__ __host__ __device__ T min(T a, T b) { return b < a ? b : a; }                \
    static __inline__ __host__ __device__ T max(T a, T b) { return a < b ? b : a; }
SUNSTONE_MINMAX(int)
SUNSTONE_MINMAX(unsigned int)
SUNSTONE_MINMAX(long)
SUNSTONE_MINMAX(unsigned long)
SUNSTONE_MINMAX(long long)
SUNSTONE_MINMAX(unsigned long long)
#undef SUNSTONE_MINMAX
#define SUNSTONE_MINMAX_MIXED(A, B, T)                                                             \
    static __inline__ __host__ __device__ T min(A a, B b) { return min((T)a, (T)b); }              \
    static __inline__ __host__ __device__ T max(A a, B b) { return max((T)a, (T)b); }              \
    static __inline__ __host__ __device__ T min(B a, A b) { return min((T)a, (T)b); }              \
    static __inline__ __host__ __device__ T max(B a, A b) { return max((T)a, (T)b); }
SUNSTONE_MINMAX_MIXED(int, unsigned int, unsigned int)
SUNSTONE_MINMAX_MIXED(long, unsigned long, unsigned long)
SUNSTONE_MINMAX_MIXED(long long, unsigned long long, unsigned long long)
#undef SUNSTONE_MINMAX_MIXED
SUNSTONE_DEVICE float min(float a, float b) { return fminf(a, b); }
SUNSTONE_DEVICE float max(float a, float b) { return fmaxf(a, b); }
SUNSTONE_DEVICE double min(double a, double b) { return fmin(a, b); }
SUNSTONE_DEVICE double max(double a, double b) { return fmax(a, b); }
SUNSTONE_DEVICE double min(float a, double b) { return fmin((double)a, b); }
SUNSTONE_DEVICE double max(float a, double b) { return fmax((double)a, b); }
SUNSTONE_DEVICE double min(double a, float b) { return fmin(a, (double)b); }
SUNSTONE_DEVICE double max(double a, float b) { return fmax(a, (double)b); }
// Their host counterparts.
#define SUNSTONE_HOST_MINMAX(A, B, T)                                                              \
    static __inline__ __host__ T min(A a, B b) { return (T)b < (T)a || a != a ? (T)b : (T)a; }     \
    static __inline__ __host__ T max(A a, B b) { return (T)a < (T)b || a != a ? (T)b : (T)a; }
SUNSTONE_HOST_MINMAX(float, float, float)
SUNSTONE_HOST_MINMAX(double, double, double)
SUNSTONE_HOST_MINMAX(float, double, double)
SUNSTONE_HOST_MINMAX(double, float, double)
#undef SUNSTONE_HOST_MINMAX
static __inline__ __host__ float rsqrtf(float x) { return 1.0f / __builtin_sqrtf(x); }
static __inline__ __host__ double rsqrt(double x) { return 1.0 / __builtin_sqrt(x); }
static __inline__ __host__ float rsqrt(float x) { return rsqrtf(x); }
static __inline__ __host__ float rcbrtf(float x) {
    return 1.0f / __builtin_cbrtf(x);
}
static __inline__ __host__ double rcbrt(double x) {
    return 1.0 / __builtin_cbrt(x);
}
static __inline__ __host__ float rcbrt(float x) {
    return rcbrtf(x);
}
#if !defined(__GLIBC__) || __GLIBC__ == 2 && __GLIBC_MINOR__ < 41 // newer ones have these functions
// The argument is reduced to a turn before the product with pi is rounded.
static __inline__ __host__ double sinpi(double x) {
    const double turn = __builtin_remainder(x, 2.0);
    return turn == __builtin_trunc(turn) ? turn * 0.0 : __builtin_sin(turn * 3.141592653589793);
}
static __inline__ __host__ double cospi(double x) {
    const double turn = __builtin_fabs(__builtin_remainder(x, 2.0));
    return turn == 0.5 ? 0.0 : __builtin_cos(turn * 3.141592653589793);
}
static __inline__ __host__ float sinpif(float x) {
    return (float)sinpi((double)x);
}
static __inline__ __host__ float cospif(float x) {
    return (float)cospi((double)x);
}
#endif
static __inline__ __host__ float sinpi(float x) {
    return sinpif(x);
}
static __inline__ __host__ float cospi(float x) {
    return cospif(x);
}
static __inline__ __host__ void sincospi(double x, double* sine, double* cosine) {
    *sine = sinpi(x);
    *cosine = cospi(x);
}
static __inline__ __host__ void sincospif(float x, float* sine, float* cosine) {
    *sine = sinpif(x);
    *cosine = cospif(x);
}

namespace std {
using ::abs;
using ::acos;
using ::acosh;
using ::asin;
using ::asinh;
using ::atan;
using ::atan2;
using ::atanh;
using ::cbrt;
using ::ceil;
using ::copysign;
using ::cos;
using ::cosh;
using ::erf;
using ::erfc;
using ::exp;
using ::exp2;
using ::expm1;
using ::fabs;
using ::fdim;
using ::floor;
using ::fma;
using ::fmax;
using ::fmin;
using ::fmod;
using ::frexp;
using ::hypot;
using ::ilogb;
using ::labs;
using ::ldexp;
using ::lgamma;
using ::llabs;
using ::llrint;
using ::llround;
using ::log;
using ::log10;
using ::log1p;
using ::log2;
using ::logb;
using ::lrint;
using ::lround;
using ::modf;
using ::nan;
using ::nearbyint;
using ::nextafter;
using ::pow;
using ::remainder;
using ::remquo;
using ::rint;
using ::round;
using ::scalbn;
using ::sin;
using ::sinh;
using ::sqrt;
using ::tan;
using ::tanh;
using ::tgamma;
using ::trunc;
using ::acosf;
using ::acoshf;
using ::asinf;
using ::asinhf;
using ::atan2f;
using ::atanf;
using ::atanhf;
using ::cbrtf;
using ::ceilf;
using ::copysignf;
using ::cosf;
using ::coshf;
using ::erfcf;
using ::erff;
using ::exp2f;
using ::expf;
using ::expm1f;
using ::fabsf;
using ::fdimf;
using ::floorf;
using ::fmaf;
using ::fmaxf;
using ::fminf;
using ::fmodf;
using ::frexpf;
using ::hypotf;
using ::ilogbf;
using ::ldexpf;
using ::lgammaf;
using ::llrintf;
using ::llroundf;
using ::log10f;
using ::log1pf;
using ::log2f;
using ::logbf;
using ::logf;
using ::lrintf;
using ::lroundf;
using ::modff;
using ::nanf;
using ::nearbyintf;
using ::nextafterf;
using ::powf;
using ::remainderf;
using ::remquof;
using ::rintf;
using ::roundf;
using ::scalbnf;
using ::sinf;
using ::sinhf;
using ::sqrtf;
using ::tanf;
using ::tanhf;
using ::tgammaf;
using ::truncf;
} // namespace std

#endif
