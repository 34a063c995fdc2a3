// SPDX-License-Identifier: Apache-2.0
// Arithmetic, comparisons, mathematics, memory and warp functions of one 16-bit format. Included
// once for each format after narrow_types.h, which has the macros; SUNSTONE_FUSED is a * b + c of
// three numbers. A sum, product, quotient or root computed as float and then rounded equals the
// exact result rounded once, because a float has more than twice the bits.

#define SUNSTONE_N SUNSTONE_NARROW
#define SUNSTONE_N2 SUNSTONE_NARROW2
#define SUNSTONE_NEAR sunstone_narrow::SUNSTONE_NAME(nearest_, )

// ---- arithmetic -----------------------------------------------------------------------------------
namespace sunstone_narrow {
// Between 0 and 1, NaN as 0.
SUNSTONE_BOTH SUNSTONE_N saturated(SUNSTONE_N x) {
    const float wide = widen(x);
    return wide > 0 ? (wide < 1 ? x : SUNSTONE_NEAR(1)) : SUNSTONE_NEAR(0);
}
SUNSTONE_BOTH SUNSTONE_N rectified(SUNSTONE_N x) {
    return isNan(x) ? SUNSTONE_NAME(bitsTo_, )(0x7fff) : widen(x) > 0 ? x : SUNSTONE_NEAR(0);
}
// The greater of two numbers; `nan`: NaN if either is NaN, else the other one. -0 is less than +0.
SUNSTONE_BOTH SUNSTONE_N greater(SUNSTONE_N a, SUNSTONE_N b, bool nan) {
    if (isNan(a) || isNan(b))
        return nan || (isNan(a) && isNan(b)) ? SUNSTONE_NAME(bitsTo_, )(0x7fff) : isNan(a) ? b : a;
    return widen(a) > widen(b) || (widen(a) == widen(b) && (b.__x & 0x8000)) ? a : b;
}
SUNSTONE_BOTH SUNSTONE_N less(SUNSTONE_N a, SUNSTONE_N b, bool nan) {
    if (isNan(a) || isNan(b))
        return greater(a, b, nan);
    return widen(a) < widen(b) || (widen(a) == widen(b) && (a.__x & 0x8000)) ? a : b;
}
} // namespace sunstone_narrow

#define SUNSTONE_BINARY(name, result)                                                              \
    SUNSTONE_BOTH SUNSTONE_N name(SUNSTONE_N a, SUNSTONE_N b) { return result; }
#define SUNSTONE_PAIR(name2, name)                                                                 \
    SUNSTONE_BOTH SUNSTONE_N2 name2(SUNSTONE_N2 a, SUNSTONE_N2 b) {                                \
        return SUNSTONE_N2(name(a.x, b.x), name(a.y, b.y));                                        \
    }
#define SUNSTONE_OPERATION(word, operation)                                                        \
    SUNSTONE_BINARY(__h##word, SUNSTONE_NEAR(sunstone_narrow::widen(a)                             \
                                                 operation sunstone_narrow::widen(b)))             \
    SUNSTONE_BINARY(__h##word##_sat, sunstone_narrow::saturated(__h##word(a, b)))                  \
    SUNSTONE_PAIR(__h##word##2, __h##word)                                                         \
    SUNSTONE_PAIR(__h##word##2_sat, __h##word##_sat)
SUNSTONE_OPERATION(add, +)
SUNSTONE_OPERATION(sub, -)
SUNSTONE_OPERATION(mul, *)
#undef SUNSTONE_OPERATION
// These are never contracted to fused operations.
SUNSTONE_BINARY(__hadd_rn, SUNSTONE_NEAR(sunstone_narrow::add(sunstone_narrow::widen(a),
                                                              sunstone_narrow::widen(b))))
SUNSTONE_BINARY(__hsub_rn, SUNSTONE_NEAR(sunstone_narrow::add(sunstone_narrow::widen(a),
                                                              -sunstone_narrow::widen(b))))
SUNSTONE_BINARY(__hmul_rn, SUNSTONE_NEAR(sunstone_narrow::multiply(sunstone_narrow::widen(a),
                                                                   sunstone_narrow::widen(b))))
SUNSTONE_BINARY(__hdiv, SUNSTONE_NEAR(sunstone_narrow::divide(sunstone_narrow::widen(a),
                                                              sunstone_narrow::widen(b))))
SUNSTONE_PAIR(__hadd2_rn, __hadd_rn)
SUNSTONE_PAIR(__hsub2_rn, __hsub_rn)
SUNSTONE_PAIR(__hmul2_rn, __hmul_rn)
SUNSTONE_PAIR(__h2div, __hdiv)
SUNSTONE_BINARY(__hmax, sunstone_narrow::greater(a, b, false))
SUNSTONE_BINARY(__hmin, sunstone_narrow::less(a, b, false))
SUNSTONE_BINARY(__hmax_nan, sunstone_narrow::greater(a, b, true))
SUNSTONE_BINARY(__hmin_nan, sunstone_narrow::less(a, b, true))
SUNSTONE_PAIR(__hmax2, __hmax)
SUNSTONE_PAIR(__hmin2, __hmin)
SUNSTONE_PAIR(__hmax2_nan, __hmax_nan)
SUNSTONE_PAIR(__hmin2_nan, __hmin_nan)

SUNSTONE_BOTH SUNSTONE_N __hfma(SUNSTONE_N a, SUNSTONE_N b, SUNSTONE_N c) {
    return sunstone_narrow::SUNSTONE_NAME(bitsTo_, )(SUNSTONE_FUSED(a, b, c));
}
SUNSTONE_BOTH SUNSTONE_N __hfma_sat(SUNSTONE_N a, SUNSTONE_N b, SUNSTONE_N c) {
    return sunstone_narrow::saturated(__hfma(a, b, c));
}
SUNSTONE_BOTH SUNSTONE_N __hfma_relu(SUNSTONE_N a, SUNSTONE_N b, SUNSTONE_N c) {
    return sunstone_narrow::rectified(__hfma(a, b, c));
}
#define SUNSTONE_FMA2(name2, name)                                                                 \
    SUNSTONE_BOTH SUNSTONE_N2 name2(SUNSTONE_N2 a, SUNSTONE_N2 b, SUNSTONE_N2 c) {                 \
        return SUNSTONE_N2(name(a.x, b.x, c.x), name(a.y, b.y, c.y));                              \
    }
SUNSTONE_FMA2(__hfma2, __hfma)
SUNSTONE_FMA2(__hfma2_sat, __hfma_sat)
SUNSTONE_FMA2(__hfma2_relu, __hfma_relu)
#undef SUNSTONE_FMA2
SUNSTONE_BOTH SUNSTONE_N __hneg(SUNSTONE_N a) {
    return sunstone_narrow::SUNSTONE_NAME(bitsTo_, )((unsigned short)(a.__x ^ 0x8000));
}
SUNSTONE_BOTH SUNSTONE_N __habs(SUNSTONE_N a) {
    return sunstone_narrow::SUNSTONE_NAME(bitsTo_, )((unsigned short)(a.__x & 0x7fff));
}
SUNSTONE_BOTH SUNSTONE_N2 __hneg2(SUNSTONE_N2 a) { return SUNSTONE_N2(__hneg(a.x), __hneg(a.y)); }
SUNSTONE_BOTH SUNSTONE_N2 __habs2(SUNSTONE_N2 a) { return SUNSTONE_N2(__habs(a.x), __habs(a.y)); }
// a * b + c of complex numbers.
SUNSTONE_BOTH SUNSTONE_N2 __hcmadd(SUNSTONE_N2 a, SUNSTONE_N2 b, SUNSTONE_N2 c) {
    return SUNSTONE_N2(__hfma(__hneg(a.y), b.y, __hfma(a.x, b.x, c.x)),
                       __hfma(a.y, b.x, __hfma(a.x, b.y, c.y)));
}

// ---- comparisons ----------------------------------------------------------------------------------
SUNSTONE_BOTH bool __hisnan(SUNSTONE_N a) { return sunstone_narrow::isNan(a); }
SUNSTONE_BOTH int __hisinf(SUNSTONE_N a) {
    const bool infinite = (a.__x & 0x7fff) == 0x7fff >> SUNSTONE_FRACTION << SUNSTONE_FRACTION;
    return infinite ? (a.__x & 0x8000 ? -1 : 1) : 0;
}
// `u`: also true if either number is NaN.
#define SUNSTONE_COMPARE_AS(word, condition)                                                       \
    SUNSTONE_BOTH bool __h##word(SUNSTONE_N l, SUNSTONE_N r) {                                     \
        const float a = sunstone_narrow::widen(l), b = sunstone_narrow::widen(r);                  \
        return condition;                                                                          \
    }                                                                                              \
    SUNSTONE_BOTH bool __hb##word##2(SUNSTONE_N2 a, SUNSTONE_N2 b) {                               \
        return __h##word(a.x, b.x) && __h##word(a.y, b.y);                                         \
    }                                                                                              \
    SUNSTONE_BOTH SUNSTONE_N2 __h##word##2(SUNSTONE_N2 a, SUNSTONE_N2 b) {                         \
        return SUNSTONE_N2(SUNSTONE_NEAR(__h##word(a.x, b.x) ? 1.0f : 0.0f),                       \
                           SUNSTONE_NEAR(__h##word(a.y, b.y) ? 1.0f : 0.0f));                      \
    }                                                                                              \
    SUNSTONE_BOTH unsigned int __h##word##2_mask(SUNSTONE_N2 a, SUNSTONE_N2 b) {                   \
        return (__h##word(a.x, b.x) ? 0xffffu : 0u) | (__h##word(a.y, b.y) ? 0xffff0000u : 0u);    \
    }
#define SUNSTONE_COMPARE(word, operation, opposite)                                                \
    SUNSTONE_COMPARE_AS(word, a operation b)                                                       \
    SUNSTONE_COMPARE_AS(word##u, !(a opposite b))
SUNSTONE_COMPARE(lt, <, >=)
SUNSTONE_COMPARE(le, <=, >)
SUNSTONE_COMPARE(gt, >, <=)
SUNSTONE_COMPARE(ge, >=, <)
SUNSTONE_COMPARE_AS(eq, a == b)
SUNSTONE_COMPARE_AS(equ, !(a < b || a > b))
SUNSTONE_COMPARE_AS(ne, a < b || a > b)
SUNSTONE_COMPARE_AS(neu, a != b)
#undef SUNSTONE_COMPARE
#undef SUNSTONE_COMPARE_AS
SUNSTONE_BOTH SUNSTONE_N2 __hisnan2(SUNSTONE_N2 a) {
    return SUNSTONE_N2(SUNSTONE_NEAR(__hisnan(a.x) ? 1.0f : 0.0f),
                       SUNSTONE_NEAR(__hisnan(a.y) ? 1.0f : 0.0f));
}

// ---- operators ------------------------------------------------------------------------------------
#define SUNSTONE_OPERATOR(operation, T, function)                                                  \
    SUNSTONE_BOTH T operator operation(const T& a, const T& b) { return function(a, b); }          \
    SUNSTONE_BOTH T& operator operation##=(T& a, const T& b) { return a = function(a, b); }
#define SUNSTONE_OPERATORS(T, plus, minus, times, by, negative, one)                               \
    SUNSTONE_OPERATOR(+, T, plus)                                                                  \
    SUNSTONE_OPERATOR(-, T, minus)                                                                 \
    SUNSTONE_OPERATOR(*, T, times)                                                                 \
    SUNSTONE_OPERATOR(/, T, by)                                                                    \
    SUNSTONE_BOTH T operator+(const T& a) { return a; }                                            \
    SUNSTONE_BOTH T operator-(const T& a) { return negative(a); }                                  \
    SUNSTONE_BOTH T& operator++(T& a) { return a = plus(a, one); }                                 \
    SUNSTONE_BOTH T& operator--(T& a) { return a = minus(a, one); }                                \
    SUNSTONE_BOTH T operator++(T& a, int) {                                                        \
        const T before = a;                                                                        \
        ++a;                                                                                       \
        return before;                                                                             \
    }                                                                                              \
    SUNSTONE_BOTH T operator--(T& a, int) {                                                        \
        const T before = a;                                                                        \
        --a;                                                                                       \
        return before;                                                                             \
    }
SUNSTONE_OPERATORS(SUNSTONE_N, __hadd, __hsub, __hmul, __hdiv, __hneg, SUNSTONE_NEAR(1))
SUNSTONE_OPERATORS(SUNSTONE_N2, __hadd2, __hsub2, __hmul2, __h2div, __hneg2,
                   SUNSTONE_N2(SUNSTONE_NEAR(1), SUNSTONE_NEAR(1)))
#undef SUNSTONE_OPERATOR
#undef SUNSTONE_OPERATORS
#define SUNSTONE_RELATION(operation, one, two)                                                     \
    SUNSTONE_BOTH bool operator operation(const SUNSTONE_N& a, const SUNSTONE_N& b) {              \
        return one(a, b);                                                                          \
    }                                                                                              \
    SUNSTONE_BOTH bool operator operation(const SUNSTONE_N2& a, const SUNSTONE_N2& b) {            \
        return two(a, b);                                                                          \
    }
SUNSTONE_RELATION(==, __heq, __hbeq2)
SUNSTONE_RELATION(!=, __hneu, __hbneu2)
SUNSTONE_RELATION(<, __hlt, __hblt2)
SUNSTONE_RELATION(<=, __hle, __hble2)
SUNSTONE_RELATION(>, __hgt, __hbgt2)
SUNSTONE_RELATION(>=, __hge, __hbge2)
#undef SUNSTONE_RELATION

#ifdef SUNSTONE_CUDA_COMPILATION
// ---- mathematics ----------------------------------------------------------------------------------
#define SUNSTONE_FUNCTION(word, result)                                                            \
    SUNSTONE_DEVICE SUNSTONE_N h##word(SUNSTONE_N a) {                                             \
        const float x = sunstone_narrow::widen(a);                                                 \
        return SUNSTONE_NEAR(result);                                                              \
    }                                                                                              \
    SUNSTONE_DEVICE SUNSTONE_N2 h2##word(SUNSTONE_N2 a) {                                          \
        return SUNSTONE_N2(h##word(a.x), h##word(a.y));                                            \
    }
SUNSTONE_FUNCTION(sqrt, __fsqrt_rn(x))
SUNSTONE_FUNCTION(rsqrt, rsqrtf(x))
SUNSTONE_FUNCTION(rcp, __frcp_rn(x))
SUNSTONE_FUNCTION(exp, expf(x))
SUNSTONE_FUNCTION(exp2, exp2f(x))
SUNSTONE_FUNCTION(exp10, exp10f(x))
SUNSTONE_FUNCTION(log, logf(x))
SUNSTONE_FUNCTION(log2, log2f(x))
SUNSTONE_FUNCTION(log10, log10f(x))
SUNSTONE_FUNCTION(sin, sinf(x))
SUNSTONE_FUNCTION(cos, cosf(x))
SUNSTONE_FUNCTION(tanh, tanhf(x))
SUNSTONE_FUNCTION(tanh_approx, tanhf(x))
SUNSTONE_FUNCTION(ceil, __builtin_ceilf(x))
SUNSTONE_FUNCTION(floor, __builtin_floorf(x))
SUNSTONE_FUNCTION(trunc, __builtin_truncf(x))
SUNSTONE_FUNCTION(rint, __builtin_rintf(x))
#undef SUNSTONE_FUNCTION

// ---- memory and warps -----------------------------------------------------------------------------
#define SUNSTONE_LOADED(name)                                                                      \
    SUNSTONE_DEVICE SUNSTONE_N name(const SUNSTONE_N* p) {                                         \
        return __builtin_bit_cast(SUNSTONE_N, name((const unsigned short*)p));                     \
    }                                                                                              \
    SUNSTONE_DEVICE SUNSTONE_N2 name(const SUNSTONE_N2* p) {                                       \
        return __builtin_bit_cast(SUNSTONE_N2, name((const unsigned int*)p));                      \
    }
SUNSTONE_LOADED(__ldg)
SUNSTONE_LOADED(__ldcg)
SUNSTONE_LOADED(__ldca)
SUNSTONE_LOADED(__ldcs)
SUNSTONE_LOADED(__ldlu)
SUNSTONE_LOADED(__ldcv)
#undef SUNSTONE_LOADED
#define SUNSTONE_STORED(name)                                                                      \
    SUNSTONE_DEVICE void name(SUNSTONE_N* p, SUNSTONE_N x) {                                       \
        name((unsigned short*)p, x.__x);                                                           \
    }                                                                                              \
    SUNSTONE_DEVICE void name(SUNSTONE_N2* p, SUNSTONE_N2 x) {                                     \
        name((unsigned int*)p, __builtin_bit_cast(unsigned int, x));                               \
    }
SUNSTONE_STORED(__stwb)
SUNSTONE_STORED(__stcg)
SUNSTONE_STORED(__stcs)
SUNSTONE_STORED(__stwt)
#undef SUNSTONE_STORED
#define SUNSTONE_SHUFFLE(name, Where)                                                              \
    SUNSTONE_DEVICE SUNSTONE_N name(unsigned mask, SUNSTONE_N x, Where where, int width = 32) {    \
        return sunstone_narrow::SUNSTONE_NAME(bitsTo_, )(                                          \
            (unsigned short)name(mask, (unsigned int)x.__x, where, width));                        \
    }                                                                                              \
    SUNSTONE_DEVICE SUNSTONE_N2 name(unsigned mask, SUNSTONE_N2 x, Where where, int width = 32) {  \
        return __builtin_bit_cast(                                                                 \
            SUNSTONE_N2, name(mask, __builtin_bit_cast(unsigned int, x), where, width));           \
    }
SUNSTONE_SHUFFLE(__shfl_sync, int)
SUNSTONE_SHUFFLE(__shfl_up_sync, unsigned int)
SUNSTONE_SHUFFLE(__shfl_down_sync, unsigned int)
SUNSTONE_SHUFFLE(__shfl_xor_sync, int)
#undef SUNSTONE_SHUFFLE

// Each half is added separately, like the instruction does, by exchanging the word that contains
// it.
SUNSTONE_DEVICE SUNSTONE_N2 atomicAdd(SUNSTONE_N2* p, SUNSTONE_N2 x) {
    unsigned int seen = *(volatile unsigned int*)p, expected;
    do {
        expected = seen;
        const SUNSTONE_N2 sum = __hadd2_rn(__builtin_bit_cast(SUNSTONE_N2, expected), x);
        seen = atomicCAS((unsigned int*)p, expected, __builtin_bit_cast(unsigned int, sum));
    } while (seen != expected);
    return __builtin_bit_cast(SUNSTONE_N2, seen);
}
SUNSTONE_DEVICE SUNSTONE_N atomicAdd(SUNSTONE_N* p, SUNSTONE_N x) {
    unsigned int* const word = (unsigned int*)((unsigned long long)p & ~2ull);
    const unsigned int shift = (unsigned long long)p & 2 ? 16 : 0;
    unsigned int seen = *(volatile unsigned int*)word, expected;
    do {
        expected = seen;
        const SUNSTONE_N sum = __hadd_rn(
            sunstone_narrow::SUNSTONE_NAME(bitsTo_, )((unsigned short)(expected >> shift)), x);
        seen = atomicCAS(word, expected,
                         (expected & ~(0xffffu << shift)) | (unsigned int)sum.__x << shift);
    } while (seen != expected);
    return sunstone_narrow::SUNSTONE_NAME(bitsTo_, )((unsigned short)(seen >> shift));
}
#endif

#undef SUNSTONE_BINARY
#undef SUNSTONE_PAIR
#undef SUNSTONE_N
#undef SUNSTONE_N2
#undef SUNSTONE_NEAR
#undef SUNSTONE_NAME
#undef SUNSTONE_NAME2
#undef SUNSTONE_PASTE
#undef SUNSTONE_PASTE_
#undef SUNSTONE_RAW
#undef SUNSTONE_RAW2
#undef SUNSTONE_NARROW
#undef SUNSTONE_NARROW2
#undef SUNSTONE_WORD
#undef SUNSTONE_WORD2
#undef SUNSTONE_FRACTION
#undef SUNSTONE_WIDEN
#undef SUNSTONE_NEAREST
#undef SUNSTONE_FUSED
