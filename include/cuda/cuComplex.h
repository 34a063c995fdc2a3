// SPDX-License-Identifier: Apache-2.0
// Complex numbers as vectors of two: real part x, imaginary part y. Products and quotients are
// those of the definition; quotients and absolute values are scaled against overflow.
// Source: CUDA documentation of cuComplex.h's functions.
#ifndef SUNSTONE_CU_COMPLEX_H
#define SUNSTONE_CU_COMPLEX_H
#ifndef CU_COMPLEX_H_
#define CU_COMPLEX_H_ // disables a toolkit's header

#include "vector_functions.h"
#include "vector_types.h"

#if !defined(__CUDACC_RTC__)
#include <math.h>
#endif

#define SUNSTONE_COMPLEX static __inline__ __host__ __device__

typedef float2 cuFloatComplex;
typedef double2 cuDoubleComplex;
typedef cuFloatComplex cuComplex;

SUNSTONE_COMPLEX float cuCrealf(cuFloatComplex z) {
    return z.x;
}
SUNSTONE_COMPLEX float cuCimagf(cuFloatComplex z) {
    return z.y;
}
SUNSTONE_COMPLEX cuFloatComplex make_cuFloatComplex(float real, float imaginary) {
    cuFloatComplex z;
    z.x = real;
    z.y = imaginary;
    return z;
}
SUNSTONE_COMPLEX cuFloatComplex cuConjf(cuFloatComplex z) {
    return make_cuFloatComplex(z.x, -z.y);
}
SUNSTONE_COMPLEX cuFloatComplex cuCaddf(cuFloatComplex a, cuFloatComplex b) {
    return make_cuFloatComplex(a.x + b.x, a.y + b.y);
}
SUNSTONE_COMPLEX cuFloatComplex cuCsubf(cuFloatComplex a, cuFloatComplex b) {
    return make_cuFloatComplex(a.x - b.x, a.y - b.y);
}
SUNSTONE_COMPLEX cuFloatComplex cuCmulf(cuFloatComplex a, cuFloatComplex b) {
    return make_cuFloatComplex(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}
SUNSTONE_COMPLEX cuFloatComplex cuCdivf(cuFloatComplex a, cuFloatComplex b) {
    const float scale = 1.0f / (fabsf(b.x) + fabsf(b.y));
    const float ax = a.x * scale, ay = a.y * scale, bx = b.x * scale, by = b.y * scale;
    const float over = 1.0f / (bx * bx + by * by);
    return make_cuFloatComplex((ax * bx + ay * by) * over, (ay * bx - ax * by) * over);
}
SUNSTONE_COMPLEX float cuCabsf(cuFloatComplex z) {
    const float x = fabsf(z.x), y = fabsf(z.y);
    const float more = x > y ? x : y, less = x > y ? y : x;
    if (more == 0 || more - more != 0) // zero, infinite or NaN
        return x + y;
    const float ratio = less / more;
    return more * sqrtf(1.0f + ratio * ratio);
}
SUNSTONE_COMPLEX cuFloatComplex cuCfmaf(cuFloatComplex a, cuFloatComplex b, cuFloatComplex c) {
    return make_cuFloatComplex(a.x * b.x + c.x - a.y * b.y, a.x * b.y + c.y + a.y * b.x);
}

SUNSTONE_COMPLEX double cuCreal(cuDoubleComplex z) {
    return z.x;
}
SUNSTONE_COMPLEX double cuCimag(cuDoubleComplex z) {
    return z.y;
}
SUNSTONE_COMPLEX cuDoubleComplex make_cuDoubleComplex(double real, double imaginary) {
    cuDoubleComplex z;
    z.x = real;
    z.y = imaginary;
    return z;
}
SUNSTONE_COMPLEX cuDoubleComplex cuConj(cuDoubleComplex z) {
    return make_cuDoubleComplex(z.x, -z.y);
}
SUNSTONE_COMPLEX cuDoubleComplex cuCadd(cuDoubleComplex a, cuDoubleComplex b) {
    return make_cuDoubleComplex(a.x + b.x, a.y + b.y);
}
SUNSTONE_COMPLEX cuDoubleComplex cuCsub(cuDoubleComplex a, cuDoubleComplex b) {
    return make_cuDoubleComplex(a.x - b.x, a.y - b.y);
}
SUNSTONE_COMPLEX cuDoubleComplex cuCmul(cuDoubleComplex a, cuDoubleComplex b) {
    return make_cuDoubleComplex(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}
SUNSTONE_COMPLEX cuDoubleComplex cuCdiv(cuDoubleComplex a, cuDoubleComplex b) {
    const double scale = 1.0 / (fabs(b.x) + fabs(b.y));
    const double ax = a.x * scale, ay = a.y * scale, bx = b.x * scale, by = b.y * scale;
    const double over = 1.0 / (bx * bx + by * by);
    return make_cuDoubleComplex((ax * bx + ay * by) * over, (ay * bx - ax * by) * over);
}
SUNSTONE_COMPLEX double cuCabs(cuDoubleComplex z) {
    const double x = fabs(z.x), y = fabs(z.y);
    const double more = x > y ? x : y, less = x > y ? y : x;
    if (more == 0 || more - more != 0) // zero, infinite or NaN
        return x + y;
    const double ratio = less / more;
    return more * sqrt(1.0 + ratio * ratio);
}
SUNSTONE_COMPLEX cuDoubleComplex cuCfma(cuDoubleComplex a, cuDoubleComplex b, cuDoubleComplex c) {
    return make_cuDoubleComplex(a.x * b.x + c.x - a.y * b.y, a.x * b.y + c.y + a.y * b.x);
}

SUNSTONE_COMPLEX cuComplex make_cuComplex(float real, float imaginary) {
    return make_cuFloatComplex(real, imaginary);
}
SUNSTONE_COMPLEX cuDoubleComplex cuComplexFloatToDouble(cuFloatComplex z) {
    return make_cuDoubleComplex(z.x, z.y);
}
SUNSTONE_COMPLEX cuFloatComplex cuComplexDoubleToFloat(cuDoubleComplex z) {
    return make_cuFloatComplex((float)z.x, (float)z.y);
}

#undef SUNSTONE_COMPLEX

#endif
#endif
