// SPDX-License-Identifier: Apache-2.0
// Arithmetic of vectors and the functions of shading, sampling and intersection that programs of
// the classic API use, for host and device. Names follow the Cg library. optixu_math.h makes them
// visible outside namespace optix. Source: OptiX API reference 6.0, sections 6.1.3, 7.33, 8.32.
//
// Families of overloads come from macros: V is a vector type without its number of components, S
// the type of a component, N that number. The macros are removed at the end.
#ifndef SUNSTONE_OPTIXU_MATH_NAMESPACE_H
#define SUNSTONE_OPTIXU_MATH_NAMESPACE_H

#define OPTIXU_MATH_DEFINE_IN_NAMESPACE

#include "../internal/optix_datatypes.h"
#include "optixu_vector_functions.h"

#ifndef __CUDACC_RTC__
#include <math.h>
#endif
#ifndef __CUDACC__
#include <string.h>
#endif

#ifndef OPTIXU_INLINE_DEFINED
#define OPTIXU_INLINE_DEFINED 1
#ifdef __CUDACC__
#define OPTIXU_INLINE __forceinline__
#else
#define OPTIXU_INLINE inline
#endif
#endif

// math.h has them from glibc 2.35 on.
#ifndef M_PIf
#define M_PIf 3.14159265358979323846f
#endif
#ifndef M_PI_2f
#define M_PI_2f 1.57079632679489661923f
#endif
#ifndef M_1_PIf
#define M_1_PIf 0.31830988618379067154f
#endif

#define SUNSTONE_FUNCTION OPTIXU_INLINE RT_HOSTDEVICE

namespace optix {

typedef unsigned int uint;
typedef unsigned short ushort;

// ---- CUDA's device functions, for the host --------------------------------------------------

using ::copysignf;
using ::fmaxf;
using ::fminf;

#ifdef __CUDACC__
using ::max;
using ::min;
#else
#define SUNSTONE_SCALAR_MIN_MAX(S)                                                                 \
    OPTIXU_INLINE S max(S a, S b) {                                                                \
        return a < b ? b : a;                                                                      \
    }                                                                                              \
    OPTIXU_INLINE S min(S a, S b) {                                                                \
        return b < a ? b : a;                                                                      \
    }
SUNSTONE_SCALAR_MIN_MAX(int)
SUNSTONE_SCALAR_MIN_MAX(unsigned int)
SUNSTONE_SCALAR_MIN_MAX(long long)
SUNSTONE_SCALAR_MIN_MAX(unsigned long long)
#undef SUNSTONE_SCALAR_MIN_MAX
#endif

/** The bits of a float. */
SUNSTONE_FUNCTION int float_as_int(const float f) {
#ifdef __CUDA_ARCH__
    return __float_as_int(f);
#else
    int i;
    memcpy(&i, &f, sizeof(i));
    return i;
#endif
}

/** The float with these bits. */
SUNSTONE_FUNCTION float int_as_float(int i) {
#ifdef __CUDA_ARCH__
    return __int_as_float(i);
#else
    float f;
    memcpy(&f, &i, sizeof(f));
    return f;
#endif
}

// ---- Lists of components ----------------------------------------------------------------------

// f of the components of a; of a and b; of v, a and b; of v and the scalars a and b.
#define SUNSTONE_1_2(f) f(a.x), f(a.y)
#define SUNSTONE_1_3(f) SUNSTONE_1_2(f), f(a.z)
#define SUNSTONE_1_4(f) SUNSTONE_1_3(f), f(a.w)
#define SUNSTONE_2_2(f) f(a.x, b.x), f(a.y, b.y)
#define SUNSTONE_2_3(f) SUNSTONE_2_2(f), f(a.z, b.z)
#define SUNSTONE_2_4(f) SUNSTONE_2_3(f), f(a.w, b.w)
#define SUNSTONE_3_2(f) f(v.x, a.x, b.x), f(v.y, a.y, b.y)
#define SUNSTONE_3_3(f) SUNSTONE_3_2(f), f(v.z, a.z, b.z)
#define SUNSTONE_3_4(f) SUNSTONE_3_3(f), f(v.w, a.w, b.w)
#define SUNSTONE_VSS_2(f) f(v.x, a, b), f(v.y, a, b)
#define SUNSTONE_VSS_3(f) SUNSTONE_VSS_2(f), f(v.z, a, b)
#define SUNSTONE_VSS_4(f) SUNSTONE_VSS_3(f), f(v.w, a, b)
// A binary operator: of vectors, of vector and scalar, of scalar and vector.
#define SUNSTONE_VV_2(op) a.x op b.x, a.y op b.y
#define SUNSTONE_VV_3(op) SUNSTONE_VV_2(op), a.z op b.z
#define SUNSTONE_VV_4(op) SUNSTONE_VV_3(op), a.w op b.w
#define SUNSTONE_VS_2(op) a.x op b, a.y op b
#define SUNSTONE_VS_3(op) SUNSTONE_VS_2(op), a.z op b
#define SUNSTONE_VS_4(op) SUNSTONE_VS_3(op), a.w op b
#define SUNSTONE_SV_2(op) a op b.x, a op b.y
#define SUNSTONE_SV_3(op) SUNSTONE_SV_2(op), a op b.z
#define SUNSTONE_SV_4(op) SUNSTONE_SV_3(op), a op b.w

// ---- Families -----------------------------------------------------------------------------------

#define SUNSTONE_OPERATOR(V, N, A, B, form, op)                                                    \
    SUNSTONE_FUNCTION V##N operator op(A a, B b) {                                                 \
        return make_##V##N(SUNSTONE_##form##_##N(op));                                             \
    }
#define SUNSTONE_OPERATOR_VV(V, N, op) SUNSTONE_OPERATOR(V, N, const V##N&, const V##N&, VV, op)
#define SUNSTONE_OPERATOR_VS(V, S, N, op) SUNSTONE_OPERATOR(V, N, const V##N&, const S, VS, op)
#define SUNSTONE_OPERATOR_SV(V, S, N, op) SUNSTONE_OPERATOR(V, N, const S, const V##N&, SV, op)
#define SUNSTONE_COMPOUND_V(V, N, op)                                                              \
    SUNSTONE_FUNCTION void operator op##=(V##N& a, const V##N& b) {                                \
        a = a op b;                                                                                \
    }
#define SUNSTONE_COMPOUND_S(V, S, N, op)                                                           \
    SUNSTONE_FUNCTION void operator op##=(V##N& a, const S b) {                                    \
        a = a op b;                                                                                \
    }

// make_VN of one value; of the components of another vector type.
#define SUNSTONE_MAKE_2(V, S)                                                                      \
    SUNSTONE_FUNCTION V##2 make_##V##2(const S s) {                                                \
        return make_##V##2(s, s);                                                                  \
    }
#define SUNSTONE_MAKE_3(V, S)                                                                      \
    SUNSTONE_FUNCTION V##3 make_##V##3(const S s) {                                                \
        return make_##V##3(s, s, s);                                                               \
    }
#define SUNSTONE_MAKE_4(V, S)                                                                      \
    SUNSTONE_FUNCTION V##4 make_##V##4(const S s) {                                                \
        return make_##V##4(s, s, s, s);                                                            \
    }
#define SUNSTONE_CONVERT(V, S, N, From)                                                            \
    SUNSTONE_FUNCTION V##N make_##V##N(const From##N& a) {                                         \
        return make_##V##N(SUNSTONE_1_##N(static_cast<S>));                                        \
    }

// The first components of a wider vector, and wider vectors from parts.
#define SUNSTONE_NARROW(V)                                                                         \
    SUNSTONE_FUNCTION V##2 make_##V##2(const V##3 & v0) {                                          \
        return make_##V##2(v0.x, v0.y);                                                            \
    }                                                                                              \
    SUNSTONE_FUNCTION V##2 make_##V##2(const V##4 & v0) {                                          \
        return make_##V##2(v0.x, v0.y);                                                            \
    }                                                                                              \
    SUNSTONE_FUNCTION V##3 make_##V##3(const V##4 & v0) {                                          \
        return make_##V##3(v0.x, v0.y, v0.z);                                                      \
    }
#define SUNSTONE_ASSEMBLE(V, S)                                                                    \
    SUNSTONE_FUNCTION V##3 make_##V##3(const S v0, const V##2 & v1) {                              \
        return make_##V##3(v0, v1.x, v1.y);                                                        \
    }                                                                                              \
    SUNSTONE_FUNCTION V##3 make_##V##3(const V##2 & v0, const S v1) {                              \
        return make_##V##3(v0.x, v0.y, v1);                                                        \
    }                                                                                              \
    SUNSTONE_FUNCTION V##4 make_##V##4(const S v0, const S v1, const V##2 & v2) {                  \
        return make_##V##4(v0, v1, v2.x, v2.y);                                                    \
    }                                                                                              \
    SUNSTONE_FUNCTION V##4 make_##V##4(const S v0, const V##2 & v1, const S v2) {                  \
        return make_##V##4(v0, v1.x, v1.y, v2);                                                    \
    }                                                                                              \
    SUNSTONE_FUNCTION V##4 make_##V##4(const V##2 & v0, const S v1, const S v2) {                  \
        return make_##V##4(v0.x, v0.y, v1, v2);                                                    \
    }                                                                                              \
    SUNSTONE_FUNCTION V##4 make_##V##4(const S v0, const V##3 & v1) {                              \
        return make_##V##4(v0, v1.x, v1.y, v1.z);                                                  \
    }                                                                                              \
    SUNSTONE_FUNCTION V##4 make_##V##4(const V##3 & v0, const S v1) {                              \
        return make_##V##4(v0.x, v0.y, v0.z, v1);                                                  \
    }                                                                                              \
    SUNSTONE_FUNCTION V##4 make_##V##4(const V##2 & v0, const V##2 & v1) {                         \
        return make_##V##4(v0.x, v0.y, v1.x, v1.y);                                                \
    }

// Component i; an index beyond the last component selects the last one. Comparisons instead of an
// address keep v in registers.
#define SUNSTONE_BY_INDEX(V, S, I)                                                                 \
    SUNSTONE_FUNCTION S getByIndex(const V##1 & v, I) {                                            \
        return v.x;                                                                                \
    }                                                                                              \
    SUNSTONE_FUNCTION S getByIndex(const V##2 & v, I i) {                                          \
        return i == 0 ? v.x : v.y;                                                                 \
    }                                                                                              \
    SUNSTONE_FUNCTION S getByIndex(const V##3 & v, I i) {                                          \
        return i == 0 ? v.x : i == 1 ? v.y : v.z;                                                  \
    }                                                                                              \
    SUNSTONE_FUNCTION S getByIndex(const V##4 & v, I i) {                                          \
        return i == 0 ? v.x : i == 1 ? v.y : i == 2 ? v.z : v.w;                                   \
    }                                                                                              \
    SUNSTONE_FUNCTION void setByIndex(V##1 & v, int, S x) {                                        \
        v.x = x;                                                                                   \
    }                                                                                              \
    SUNSTONE_FUNCTION void setByIndex(V##2 & v, int i, S x) {                                      \
        v.x = i == 0 ? x : v.x;                                                                    \
        v.y = i == 0 ? v.y : x;                                                                    \
    }                                                                                              \
    SUNSTONE_FUNCTION void setByIndex(V##3 & v, int i, S x) {                                      \
        v.x = i == 0 ? x : v.x;                                                                    \
        v.y = i == 1 ? x : v.y;                                                                    \
        v.z = i == 0 || i == 1 ? v.z : x;                                                          \
    }                                                                                              \
    SUNSTONE_FUNCTION void setByIndex(V##4 & v, int i, S x) {                                      \
        v.x = i == 0 ? x : v.x;                                                                    \
        v.y = i == 1 ? x : v.y;                                                                    \
        v.z = i == 2 ? x : v.z;                                                                    \
        v.w = i == 0 || i == 1 || i == 2 ? v.w : x;                                                \
    }

#define SUNSTONE_CLAMP(V, S, N)                                                                    \
    SUNSTONE_FUNCTION V##N clamp(const V##N& v, const S a, const S b) {                            \
        return make_##V##N(SUNSTONE_VSS_##N(clamp));                                               \
    }                                                                                              \
    SUNSTONE_FUNCTION V##N clamp(const V##N& v, const V##N& a, const V##N& b) {                    \
        return make_##V##N(SUNSTONE_3_##N(clamp));                                                 \
    }

// ---- Vectors of floats --------------------------------------------------------------------------

/** a + t * (b - a). */
SUNSTONE_FUNCTION float lerp(const float a, const float b, const float t) {
    return a + t * (b - a);
}
/** Interpolates between four corners: u from x00 to x10, v from x00 to x01. */
SUNSTONE_FUNCTION float bilerp(const float x00, const float x10, const float x01, const float x11,
                               const float u, const float v) {
    return lerp(lerp(x00, x10, u), lerp(x01, x11, u), v);
}
/** f, at least a and at most b. */
SUNSTONE_FUNCTION float clamp(const float f, const float a, const float b) {
    return fmaxf(a, fminf(f, b));
}

#define SUNSTONE_FLOATS_N(N)                                                                       \
    SUNSTONE_CONVERT(float, float, N, int)                                                         \
    SUNSTONE_CONVERT(float, float, N, uint)                                                        \
    SUNSTONE_FUNCTION float##N operator-(const float##N& a) {                                      \
        return make_float##N(SUNSTONE_1_##N(-));                                                   \
    }                                                                                              \
    SUNSTONE_OPERATOR_VV(float, N, +)                                                              \
    SUNSTONE_OPERATOR_VS(float, float, N, +)                                                       \
    SUNSTONE_OPERATOR_SV(float, float, N, +)                                                       \
    SUNSTONE_COMPOUND_V(float, N, +)                                                               \
    SUNSTONE_OPERATOR_VV(float, N, -)                                                              \
    SUNSTONE_OPERATOR_VS(float, float, N, -)                                                       \
    SUNSTONE_OPERATOR_SV(float, float, N, -)                                                       \
    SUNSTONE_COMPOUND_V(float, N, -)                                                               \
    SUNSTONE_OPERATOR_VV(float, N, *)                                                              \
    SUNSTONE_OPERATOR_VS(float, float, N, *)                                                       \
    SUNSTONE_OPERATOR_SV(float, float, N, *)                                                       \
    SUNSTONE_COMPOUND_V(float, N, *)                                                               \
    SUNSTONE_COMPOUND_S(float, float, N, *)                                                        \
    SUNSTONE_OPERATOR_VV(float, N, /)                                                              \
    SUNSTONE_OPERATOR_VS(float, float, N, /)                                                       \
    SUNSTONE_OPERATOR_SV(float, float, N, /)                                                       \
    SUNSTONE_COMPOUND_S(float, float, N, /)                                                        \
    SUNSTONE_CLAMP(float, float, N)                                                                \
    SUNSTONE_FUNCTION float##N fminf(const float##N& a, const float##N& b) {                       \
        return make_float##N(SUNSTONE_2_##N(fminf));                                               \
    }                                                                                              \
    SUNSTONE_FUNCTION float##N fmaxf(const float##N& a, const float##N& b) {                       \
        return make_float##N(SUNSTONE_2_##N(fmaxf));                                               \
    }                                                                                              \
    SUNSTONE_FUNCTION float##N floor(const float##N& a) {                                          \
        return make_float##N(SUNSTONE_1_##N(::floorf));                                            \
    }                                                                                              \
    SUNSTONE_FUNCTION float##N expf(const float##N& a) {                                           \
        return make_float##N(SUNSTONE_1_##N(::expf));                                              \
    }                                                                                              \
    SUNSTONE_FUNCTION float##N lerp(const float##N& a, const float##N& b, const float t) {         \
        return a + t * (b - a);                                                                    \
    }                                                                                              \
    SUNSTONE_FUNCTION float##N bilerp(const float##N& x00, const float##N& x10,                    \
                                      const float##N& x01, const float##N& x11, const float u,     \
                                      const float v) {                                             \
        return lerp(lerp(x00, x10, u), lerp(x01, x11, u), v);                                      \
    }

SUNSTONE_MAKE_2(float, float)
SUNSTONE_MAKE_3(float, float)
SUNSTONE_MAKE_4(float, float)
SUNSTONE_FLOATS_N(2)
SUNSTONE_FLOATS_N(3)
SUNSTONE_FLOATS_N(4)
SUNSTONE_NARROW(float)
SUNSTONE_ASSEMBLE(float, float)
SUNSTONE_BY_INDEX(float, float, int)

/** The vector with 0 as the new component. */
SUNSTONE_FUNCTION float3 make_float3(const float2& a) {
    return make_float3(a.x, a.y, 0.0f);
}
/** The vector with 0 as the new component. */
SUNSTONE_FUNCTION float4 make_float4(const float3& a) {
    return make_float4(a.x, a.y, a.z, 0.0f);
}

/** The smallest component. */
SUNSTONE_FUNCTION float fminf(const float2& a) {
    return fminf(a.x, a.y);
}
SUNSTONE_FUNCTION float fminf(const float3& a) {
    return fminf(fminf(a.x, a.y), a.z);
}
SUNSTONE_FUNCTION float fminf(const float4& a) {
    return fminf(fminf(a.x, a.y), fminf(a.z, a.w));
}
/** The largest component. */
SUNSTONE_FUNCTION float fmaxf(const float2& a) {
    return fmaxf(a.x, a.y);
}
SUNSTONE_FUNCTION float fmaxf(const float3& a) {
    return fmaxf(fmaxf(a.x, a.y), a.z);
}
SUNSTONE_FUNCTION float fmaxf(const float4& a) {
    return fmaxf(fmaxf(a.x, a.y), fmaxf(a.z, a.w));
}

SUNSTONE_FUNCTION float dot(const float2& a, const float2& b) {
    return a.x * b.x + a.y * b.y;
}
SUNSTONE_FUNCTION float dot(const float3& a, const float3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
SUNSTONE_FUNCTION float dot(const float4& a, const float4& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}
SUNSTONE_FUNCTION float3 cross(const float3& a, const float3& b) {
    return make_float3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

#define SUNSTONE_GEOMETRY(N)                                                                       \
    SUNSTONE_FUNCTION float length(const float##N& v) {                                            \
        return ::sqrtf(dot(v, v));                                                                 \
    }                                                                                              \
    /** v with length 1; v must have a length other than 0. */                                     \
    SUNSTONE_FUNCTION float##N normalize(const float##N& v) {                                      \
        return v * (1.0f / ::sqrtf(dot(v, v)));                                                    \
    }                                                                                              \
    /** The mirror image of direction i at a surface with the unit normal n. */                    \
    SUNSTONE_FUNCTION float##N reflect(const float##N& i, const float##N& n) {                     \
        return i - 2.0f * dot(n, i) * n;                                                           \
    }                                                                                              \
    /** n if dot(i, nref) > 0, else -n; Cg and GLSL have the opposite sign. */                     \
    SUNSTONE_FUNCTION float##N faceforward(const float##N& n, const float##N& i,                   \
                                           const float##N& nref) {                                 \
        return dot(i, nref) > 0.0f ? n : -n;                                                       \
    }
SUNSTONE_GEOMETRY(2)
SUNSTONE_GEOMETRY(3)
SUNSTONE_GEOMETRY(4)

// ---- Vectors of integers --------------------------------------------------------------------

SUNSTONE_DEPRECATED_TYPES_BEGIN

#define SUNSTONE_EQUAL(V, N, expression)                                                           \
    SUNSTONE_FUNCTION bool operator==(const V##N& a, const V##N& b) {                              \
        return expression;                                                                         \
    }                                                                                              \
    SUNSTONE_FUNCTION bool operator!=(const V##N& a, const V##N& b) {                              \
        return !(a == b);                                                                          \
    }
#define SUNSTONE_NEGATE(V, N)                                                                      \
    SUNSTONE_FUNCTION V##N operator-(const V##N& a) {                                              \
        return make_##V##N(SUNSTONE_1_##N(-));                                                     \
    }
#define SUNSTONE_INTEGERS_N(V, S, N)                                                               \
    SUNSTONE_CONVERT(V, S, N, float)                                                               \
    SUNSTONE_FUNCTION V##N min(const V##N& a, const V##N& b) {                                     \
        return make_##V##N(SUNSTONE_2_##N(min));                                                   \
    }                                                                                              \
    SUNSTONE_FUNCTION V##N max(const V##N& a, const V##N& b) {                                     \
        return make_##V##N(SUNSTONE_2_##N(max));                                                   \
    }                                                                                              \
    SUNSTONE_OPERATOR_VV(V, N, +)                                                                  \
    SUNSTONE_COMPOUND_V(V, N, +)                                                                   \
    SUNSTONE_OPERATOR_VV(V, N, -)                                                                  \
    SUNSTONE_COMPOUND_V(V, N, -)                                                                   \
    SUNSTONE_OPERATOR_VV(V, N, *)                                                                  \
    SUNSTONE_OPERATOR_VS(V, S, N, *)                                                               \
    SUNSTONE_OPERATOR_SV(V, S, N, *)                                                               \
    SUNSTONE_COMPOUND_S(V, S, N, *)                                                                \
    SUNSTONE_CLAMP(V, S, N)
#define SUNSTONE_QUOTIENTS(V, S, N)                                                                \
    SUNSTONE_OPERATOR_VV(V, N, /)                                                                  \
    SUNSTONE_OPERATOR_VS(V, S, N, /)                                                               \
    SUNSTONE_OPERATOR_SV(V, S, N, /)                                                               \
    SUNSTONE_COMPOUND_S(V, S, N, /)
// Only two components have a difference with a scalar, only three and four have quotients.
#define SUNSTONE_INTEGERS(V, S, I)                                                                 \
    SUNSTONE_FUNCTION S clamp(const S f, const S a, const S b) {                                   \
        return max(a, min(f, b));                                                                  \
    }                                                                                              \
    SUNSTONE_MAKE_2(V, S)                                                                          \
    SUNSTONE_MAKE_3(V, S)                                                                          \
    SUNSTONE_MAKE_4(V, S)                                                                          \
    SUNSTONE_INTEGERS_N(V, S, 2)                                                                   \
    SUNSTONE_OPERATOR_VS(V, S, 2, -)                                                               \
    SUNSTONE_EQUAL(V, 2, a.x == b.x && a.y == b.y)                                                 \
    SUNSTONE_INTEGERS_N(V, S, 3)                                                                   \
    SUNSTONE_QUOTIENTS(V, S, 3)                                                                    \
    SUNSTONE_EQUAL(V, 3, a.x == b.x && a.y == b.y && a.z == b.z)                                   \
    SUNSTONE_INTEGERS_N(V, S, 4)                                                                   \
    SUNSTONE_QUOTIENTS(V, S, 4)                                                                    \
    SUNSTONE_EQUAL(V, 4, a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w)                     \
    SUNSTONE_NARROW(V)                                                                             \
    SUNSTONE_ASSEMBLE(V, S)                                                                        \
    SUNSTONE_BY_INDEX(V, S, I)
SUNSTONE_INTEGERS(int, int, int)
SUNSTONE_INTEGERS(uint, unsigned int, unsigned int)
SUNSTONE_INTEGERS(longlong, long long, int)
SUNSTONE_INTEGERS(ulonglong, unsigned long long, unsigned int)
SUNSTONE_NEGATE(int, 2)
SUNSTONE_NEGATE(int, 3)
SUNSTONE_NEGATE(int, 4)
SUNSTONE_NEGATE(longlong, 2)
SUNSTONE_NEGATE(longlong, 3)
SUNSTONE_NEGATE(longlong, 4)

SUNSTONE_DEPRECATED_TYPES_END

// ---- Shading ------------------------------------------------------------------------------------

/** 0 for x at most edge0, 1 for x at least edge1, a smooth transition between. */
SUNSTONE_FUNCTION float smoothstep(const float edge0, const float edge1, const float x) {
    const float t = clamp((x - edge0) / (edge1 - edge0), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

/** A colour for t from 0 to 1: blue over green to red. */
SUNSTONE_FUNCTION float3 temperature(const float t) {
    const float red = smoothstep(0.5f, 0.75f, t);
    const float green = smoothstep(0.0f, 0.5f, t) * (1.0f - smoothstep(0.75f, 1.0f, t));
    const float blue = 1.0f - smoothstep(0.25f, 0.5f, t);
    return make_float3(red, green, blue);
}

/** Direction r of light that meets a surface with unit normal n in unit direction i, from either
    side; ior is the index of refraction on the side opposite to n over the index on the side of n.
    Returns false, with r = 0, on total internal reflection. */
SUNSTONE_FUNCTION bool refract(float3& r, const float3& i, const float3& n, const float ior) {
    const float along = dot(i, n);
    const bool leaves = along > 0.0f;
    const float eta = leaves ? ior : 1.0f / ior;
    const float cosineSquared = 1.0f - eta * eta * (1.0f - along * along);
    if (cosineSquared < 0.0f) {
        r = make_float3(0.0f);
        return false;
    }
    const float cosine = ::sqrtf(cosineSquared);
    r = normalize(eta * i + ((leaves ? cosine : -cosine) - eta * along) * n);
    return true;
}

/** Schlick's approximation of Fresnel reflectance: minimum at cos_theta 1, maximum at 0. */
SUNSTONE_FUNCTION float fresnel_schlick(const float cos_theta, const float exponent = 5.0f,
                                        const float minimum = 0.0f, const float maximum = 1.0f) {
    const float weight = ::powf(1.0f - cos_theta, exponent);
    return clamp(minimum + (maximum - minimum) * weight, minimum, maximum);
}
SUNSTONE_FUNCTION float3 fresnel_schlick(const float cos_theta, const float exponent,
                                         const float3& minimum, const float3& maximum) {
    return make_float3(fresnel_schlick(cos_theta, exponent, minimum.x, maximum.x),
                       fresnel_schlick(cos_theta, exponent, minimum.y, maximum.y),
                       fresnel_schlick(cos_theta, exponent, minimum.z, maximum.z));
}

/** Luminance with the weights of NTSC. */
SUNSTONE_FUNCTION float luminance(const float3& rgb) {
    return dot(rgb, make_float3(0.30f, 0.59f, 0.11f));
}
/** Luminance with the weights of CIE for the primaries of sRGB. */
SUNSTONE_FUNCTION float luminanceCIE(const float3& rgb) {
    return dot(rgb, make_float3(0.2126f, 0.7152f, 0.0722f));
}

// ---- Sampling ----------------------------------------------------------------------------------

/** p: a direction around +z, with a density in proportion to its cosine if u1 and u2 are uniform in
    [0,1]. u1 is the square of the distance from the axis, u2 the angle in turns. */
SUNSTONE_FUNCTION void cosine_sample_hemisphere(const float u1, const float u2, float3& p) {
    const float radius = ::sqrtf(u1);
    const float phi = 6.2831853071795865f * u2;
    p = make_float3(radius * ::cosf(phi), radius * ::sinf(phi), ::sqrtf(fmaxf(0.0f, 1.0f - u1)));
}

/** Maps [0,1]^2 to the unit disk: squares around the centre become circles and keep their share of
    the area (Shirley and Chiu). */
SUNSTONE_FUNCTION float2 square_to_disk(const float2& sample) {
    const float x = 2.0f * sample.x - 1.0f;
    const float y = 2.0f * sample.y - 1.0f;
    if (x == 0.0f && y == 0.0f)
        return make_float2(0.0f, 0.0f);
    const float kQuarter = 0.78539816339744831f; // of a half turn
    const bool sides = ::fabsf(x) > ::fabsf(y);
    const float radius = sides ? x : y;
    const float phi = sides ? kQuarter * (y / x) : kQuarter * (2.0f - x / y);
    return make_float2(radius * ::cosf(phi), radius * ::sinf(phi));
}

/** Azimuth in [0, 2 pi), elevation in [-pi/2, pi/2], length. */
SUNSTONE_FUNCTION float3 cart_to_pol(const float3& v) {
    const float azimuth = ::atan2f(v.y, v.x);
    return make_float3(azimuth < 0.0f ? azimuth + 6.2831853071795865f : azimuth,
                       ::atan2f(v.z, length(make_float2(v))), length(v));
}

// ---- Intersection -------------------------------------------------------------------------------

/** Intersects a ray with a triangle, from either side. n: normal, not normalised, on the side from
    which the vertices are counter-clockwise; t: distance in lengths of the direction; beta, gamma:
    weights of p1 and p2. Returns true if tmin < t < tmax. Evaluates all conditions, so threads do
    not diverge. */
SUNSTONE_FUNCTION bool intersect_triangle_branchless(const Ray& ray, const float3& p0,
                                                     const float3& p1, const float3& p2, float3& n,
                                                     float& t, float& beta, float& gamma) {
    const float3 edge1 = p1 - p0;
    const float3 edge2 = p2 - p0;
    const float3 offset = p0 - ray.origin;
    n = cross(edge1, edge2);
    const float scale = 1.0f / dot(n, ray.direction);
    const float3 moment = cross(ray.direction, offset);
    t = scale * dot(n, offset);
    beta = -scale * dot(moment, edge2);
    gamma = scale * dot(moment, edge1);
    return (t < ray.tmax) & (t > ray.tmin) & (beta >= 0.0f) & (gamma >= 0.0f) &
           (beta + gamma <= 1.0f);
}

/** The same with a test after each value; the values after a failed test are not written. */
SUNSTONE_FUNCTION bool intersect_triangle_earlyexit(const Ray& ray, const float3& p0,
                                                    const float3& p1, const float3& p2, float3& n,
                                                    float& t, float& beta, float& gamma) {
    const float3 edge1 = p1 - p0;
    const float3 edge2 = p2 - p0;
    const float3 offset = p0 - ray.origin;
    n = cross(edge1, edge2);
    const float scale = 1.0f / dot(n, ray.direction);
    t = scale * dot(n, offset);
    if (!(t < ray.tmax && t > ray.tmin))
        return false;
    const float3 moment = cross(ray.direction, offset);
    beta = -scale * dot(moment, edge2);
    if (!(beta >= 0.0f))
        return false;
    gamma = scale * dot(moment, edge1);
    return gamma >= 0.0f && beta + gamma <= 1.0f;
}

/** intersect_triangle_branchless. */
SUNSTONE_FUNCTION bool intersect_triangle(const Ray& ray, const float3& p0, const float3& p1,
                                          const float3& p2, float3& n, float& t, float& beta,
                                          float& gamma) {
    return intersect_triangle_branchless(ray, p0, p1, p2, n, t, beta, gamma);
}

/** Three orthogonal unit vectors around a unit normal. */
struct Onb {
    OPTIXU_INLINE RT_HOSTDEVICE Onb(const float3& normal) : m_normal(normal) {
        m_binormal = ::fabsf(normal.x) > ::fabsf(normal.z) ? make_float3(-normal.y, normal.x, 0.0f)
                                                           : make_float3(0.0f, -normal.z, normal.y);
        m_binormal = normalize(m_binormal);
        m_tangent = cross(m_binormal, m_normal);
    }
    /** From coordinates in this basis to the space of its vectors. */
    OPTIXU_INLINE RT_HOSTDEVICE void inverse_transform(float3& p) const {
        p = p.x * m_tangent + p.y * m_binormal + p.z * m_normal;
    }

    float3 m_tangent;
    float3 m_binormal;
    float3 m_normal;
};

} // namespace optix

#undef SUNSTONE_FUNCTION
#undef SUNSTONE_1_2
#undef SUNSTONE_1_3
#undef SUNSTONE_1_4
#undef SUNSTONE_2_2
#undef SUNSTONE_2_3
#undef SUNSTONE_2_4
#undef SUNSTONE_3_2
#undef SUNSTONE_3_3
#undef SUNSTONE_3_4
#undef SUNSTONE_VSS_2
#undef SUNSTONE_VSS_3
#undef SUNSTONE_VSS_4
#undef SUNSTONE_VV_2
#undef SUNSTONE_VV_3
#undef SUNSTONE_VV_4
#undef SUNSTONE_VS_2
#undef SUNSTONE_VS_3
#undef SUNSTONE_VS_4
#undef SUNSTONE_SV_2
#undef SUNSTONE_SV_3
#undef SUNSTONE_SV_4
#undef SUNSTONE_OPERATOR
#undef SUNSTONE_OPERATOR_VV
#undef SUNSTONE_OPERATOR_VS
#undef SUNSTONE_OPERATOR_SV
#undef SUNSTONE_COMPOUND_V
#undef SUNSTONE_COMPOUND_S
#undef SUNSTONE_MAKE_2
#undef SUNSTONE_MAKE_3
#undef SUNSTONE_MAKE_4
#undef SUNSTONE_CONVERT
#undef SUNSTONE_NARROW
#undef SUNSTONE_ASSEMBLE
#undef SUNSTONE_BY_INDEX
#undef SUNSTONE_CLAMP
#undef SUNSTONE_FLOATS_N
#undef SUNSTONE_GEOMETRY
#undef SUNSTONE_EQUAL
#undef SUNSTONE_NEGATE
#undef SUNSTONE_INTEGERS_N
#undef SUNSTONE_QUOTIENTS
#undef SUNSTONE_INTEGERS

#endif
