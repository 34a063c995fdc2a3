// SPDX-License-Identifier: Apache-2.0
// Matrix products by the threads of a warp: nvcuda::wmma. Halves need sm_70, integers sm_72,
// bfloats, tf32 and doubles sm_80; matrices of 4-bit and 1-bit elements are in `experimental`.
// Source: CUDA C++ Programming Guide, "Warp Matrix Functions".
#ifndef SUNSTONE_MMA_H
#define SUNSTONE_MMA_H

#include "cuda_bf16.h"
#include "cuda_fp16.h"
#include "cuda_runtime.h"

namespace nvcuda {
namespace wmma {

enum layout_t { mem_row_major, mem_col_major };

struct matrix_a;
struct matrix_b;
struct accumulator;
struct row_major;
struct col_major;

namespace precision {
struct tf32;
}

namespace experimental {
namespace precision {
struct u4;
struct s4;
struct b1;
} // namespace precision
enum bmmaBitOp { bmmaBitOpXOR = 1, bmmaBitOpAND = 2 };
enum bmmaAccumulateOp { bmmaAccumulateOpPOPC = 1 };
} // namespace experimental

// The elements that a lane holds, and their storage.
template <class Element, class Storage, int count, int stored>
struct __sunstone_fragment {
    typedef Element element_type;
    typedef Storage storage_element_type;
    enum { num_elements = count, num_storage_elements = stored };
    Storage x[stored];
};

template <class Use, int m, int n, int k, class T, class Layout = void>
class fragment;

// ---- fragments, loads and stores ---------------------------------------------------------------

#define SUNSTONE_LIST_1(n) "{%[" #n "0]}"
#define SUNSTONE_LIST_2(n) "{%[" #n "0], %[" #n "1]}"
#define SUNSTONE_LIST_4(n) "{%[" #n "0], %[" #n "1], %[" #n "2], %[" #n "3]}"
#define SUNSTONE_LIST_8(n)                                                                         \
    "{%[" #n "0], %[" #n "1], %[" #n "2], %[" #n "3], %[" #n "4], %[" #n "5], %[" #n "6], %[" #n   \
    "7]}"
#define SUNSTONE_OPERANDS_1(n, c, v) [n##0] c(v[0])
#define SUNSTONE_OPERANDS_2(n, c, v) SUNSTONE_OPERANDS_1(n, c, v), [n##1] c(v[1])
#define SUNSTONE_OPERANDS_4(n, c, v) SUNSTONE_OPERANDS_2(n, c, v), [n##2] c(v[2]), [n##3] c(v[3])
#define SUNSTONE_OPERANDS_8(n, c, v)                                                               \
    SUNSTONE_OPERANDS_4(n, c, v), [n##4] c(v[4]), [n##5] c(v[5]), [n##6] c(v[6]), [n##7] c(v[7])

// Loads `count` registers of type R, constraint c, into a fragment.
#define SUNSTONE_LOAD_FRAGMENT(FRAGMENT, POINTER, text, count, R, c)                               \
    SUNSTONE_DEVICE void load_matrix_sync(FRAGMENT& a, const POINTER* p, unsigned ldm) {           \
        R r[count];                                                                                \
        asm volatile("wmma.load." text " " SUNSTONE_LIST_##count(r) ", [%[p]], %[ldm];"            \
                     : SUNSTONE_OPERANDS_##count(r, "=" c, r)                                      \
                     : [p] "l"(p), [ldm] "r"(ldm)                                                  \
                     : "memory");                                                                  \
        __builtin_memcpy(a.x, r, sizeof r);                                                        \
    }

#define SUNSTONE_FACTOR(use, letter, m, n, k, T, Layout, layout, type, Storage, POINTER, elements, \
                        stored, count, R, c)                                                       \
    template <>                                                                                    \
    class fragment<use, m, n, k, T, Layout>                                                        \
        : public __sunstone_fragment<T, Storage, elements, stored> {};                             \
    typedef fragment<use, m, n, k, T, Layout>                                                      \
        __sunstone_##letter##_##m##_##n##_##k##_##type##_##layout;                                 \
    SUNSTONE_LOAD_FRAGMENT(__sunstone_##letter##_##m##_##n##_##k##_##type##_##layout, POINTER,     \
                           #letter ".sync.aligned." #layout ".m" #m "n" #n "k" #k "." #type,       \
                           count, R, c)

#define SUNSTONE_FACTOR_LAYOUTS(use, letter, m, n, k, T, type, Storage, POINTER, elements, count,  \
                                R, c)                                                              \
    SUNSTONE_FACTOR(use, letter, m, n, k, T, row_major, row, type, Storage, POINTER, elements,     \
                    elements, count, R, c)                                                         \
    SUNSTONE_FACTOR(use, letter, m, n, k, T, col_major, col, type, Storage, POINTER, elements,     \
                    elements, count, R, c)

// Both factors: the number of elements and registers of A and B.
#define SUNSTONE_FACTORS(m, n, k, T, type, Storage, POINTER, elementsA, countA, elementsB, countB, \
                         R, c)                                                                     \
    SUNSTONE_FACTOR_LAYOUTS(matrix_a, a, m, n, k, T, type, Storage, POINTER, elementsA, countA, R, \
                            c)                                                                     \
    SUNSTONE_FACTOR_LAYOUTS(matrix_b, b, m, n, k, T, type, Storage, POINTER, elementsB, countB, R, \
                            c)

#define SUNSTONE_SUM(m, n, k, T, type, elements, count, R, c)                                      \
    template <>                                                                                    \
    class fragment<accumulator, m, n, k, T>                                                        \
        : public __sunstone_fragment<T, T, elements, elements> {};                                 \
    SUNSTONE_DEVICE void load_matrix_sync(fragment<accumulator, m, n, k, T>& a, const T* p,        \
                                          unsigned ldm, layout_t layout) {                         \
        R r[count];                                                                                \
        if (layout == mem_row_major)                                                               \
            asm volatile("wmma.load.c.sync.aligned.row.m" #m "n" #n "k" #k "." #type               \
                         " " SUNSTONE_LIST_##count(r) ", [%[p]], %[ldm];"                          \
                         : SUNSTONE_OPERANDS_##count(r, "=" c, r)                                  \
                         : [p] "l"(p), [ldm] "r"(ldm)                                              \
                         : "memory");                                                              \
        else                                                                                       \
            asm volatile("wmma.load.c.sync.aligned.col.m" #m "n" #n "k" #k "." #type               \
                         " " SUNSTONE_LIST_##count(r) ", [%[p]], %[ldm];"                          \
                         : SUNSTONE_OPERANDS_##count(r, "=" c, r)                                  \
                         : [p] "l"(p), [ldm] "r"(ldm)                                              \
                         : "memory");                                                              \
        __builtin_memcpy(a.x, r, sizeof r);                                                        \
    }                                                                                              \
    SUNSTONE_DEVICE void store_matrix_sync(T* p, const fragment<accumulator, m, n, k, T>& a,       \
                                           unsigned ldm, layout_t layout) {                        \
        R r[count];                                                                                \
        __builtin_memcpy(r, a.x, sizeof r);                                                        \
        if (layout == mem_row_major)                                                               \
            asm volatile("wmma.store.d.sync.aligned.row.m" #m "n" #n "k" #k "." #type              \
                         " [%[p]], " SUNSTONE_LIST_##count(r) ", %[ldm];"                          \
                         :                                                                         \
                         : [p] "l"(p), SUNSTONE_OPERANDS_##count(r, c, r), [ldm] "r"(ldm)          \
                         : "memory");                                                              \
        else                                                                                       \
            asm volatile("wmma.store.d.sync.aligned.col.m" #m "n" #n "k" #k "." #type              \
                         " [%[p]], " SUNSTONE_LIST_##count(r) ", %[ldm];"                          \
                         :                                                                         \
                         : [p] "l"(p), SUNSTONE_OPERANDS_##count(r, c, r), [ldm] "r"(ldm)          \
                         : "memory");                                                              \
    }

#define SUNSTONE_SHAPE(m, n, k, bytesA, countA, bytesB, countB, countBrainA, countBrainB)          \
    SUNSTONE_FACTORS(m, n, k, __half, f16, __half, __half, 16, 8, 16, 8, unsigned, "r")            \
    SUNSTONE_FACTORS(m, n, k, __nv_bfloat16, bf16, __nv_bfloat16, __nv_bfloat16, bytesA,           \
                     countBrainA, bytesB, countBrainB, unsigned, "r")                              \
    SUNSTONE_FACTORS(m, n, k, signed char, s8, signed char, signed char, bytesA, countA, bytesB,   \
                     countB, unsigned, "r")                                                        \
    SUNSTONE_FACTORS(m, n, k, unsigned char, u8, unsigned char, unsigned char, bytesA, countA,     \
                     bytesB, countB, unsigned, "r")                                                \
    SUNSTONE_SUM(m, n, k, __half, f16, 8, 4, unsigned, "r")                                        \
    SUNSTONE_SUM(m, n, k, float, f32, 8, 8, float, "f")                                            \
    SUNSTONE_SUM(m, n, k, int, s32, 8, 8, int, "r")
SUNSTONE_SHAPE(16, 16, 16, 8, 2, 8, 2, 4, 4)
SUNSTONE_SHAPE(8, 32, 16, 4, 1, 16, 4, 2, 8)
SUNSTONE_SHAPE(32, 8, 16, 16, 4, 4, 1, 8, 2)
SUNSTONE_FACTORS(16, 16, 8, precision::tf32, tf32, float, float, 4, 4, 4, 4, unsigned, "r")
SUNSTONE_SUM(16, 16, 8, float, f32, 8, 8, float, "f")
SUNSTONE_FACTORS(8, 8, 4, double, f64, double, double, 1, 1, 1, 1, double, "d")
SUNSTONE_SUM(8, 8, 4, double, f64, 2, 2, double, "d")
SUNSTONE_FACTOR(matrix_a, a, 8, 8, 32, experimental::precision::s4, row_major, row, s4, int, void,
                8, 1, 1, unsigned, "r")
SUNSTONE_FACTOR(matrix_b, b, 8, 8, 32, experimental::precision::s4, col_major, col, s4, int, void,
                8, 1, 1, unsigned, "r")
SUNSTONE_FACTOR(matrix_a, a, 8, 8, 32, experimental::precision::u4, row_major, row, u4, unsigned,
                void, 8, 1, 1, unsigned, "r")
SUNSTONE_FACTOR(matrix_b, b, 8, 8, 32, experimental::precision::u4, col_major, col, u4, unsigned,
                void, 8, 1, 1, unsigned, "r")
SUNSTONE_SUM(8, 8, 32, int, s32, 2, 2, int, "r")
SUNSTONE_FACTOR(matrix_a, a, 8, 8, 128, experimental::precision::b1, row_major, row, b1, unsigned,
                void, 32, 1, 1, unsigned, "r")
SUNSTONE_FACTOR(matrix_b, b, 8, 8, 128, experimental::precision::b1, col_major, col, b1, unsigned,
                void, 32, 1, 1, unsigned, "r")
SUNSTONE_SUM(8, 8, 128, int, s32, 2, 2, int, "r")

// ---- products ---------------------------------------------------------------------------------

#define SUNSTONE_PRODUCT_TEXT(text, countD, countA, countB, countC, CD, CA, CC)                    \
    asm volatile(text " " SUNSTONE_LIST_##countD(d) ", " SUNSTONE_LIST_##countA(                   \
                     a) ", " SUNSTONE_LIST_##countB(b) ", " SUNSTONE_LIST_##countC(c) ";"          \
                 : SUNSTONE_OPERANDS_##countD(d, "=" CD, rd)                                       \
                 : SUNSTONE_OPERANDS_##countA(a, CA, ra), SUNSTONE_OPERANDS_##countB(b, CA, rb),   \
                   SUNSTONE_OPERANDS_##countC(c, CC, rc))

// One combination of layouts. `types` and `saturated` end the instruction's name.
#define SUNSTONE_PRODUCT(m, n, k, T, LA, la, LB, lb, TD, TC, types, saturated, RA, countA, countB, \
                         RD, countD, CD, RC, countC, CC, CA)                                       \
    SUNSTONE_DEVICE void mma_sync(                                                                 \
        fragment<accumulator, m, n, k, TD>& d, const fragment<matrix_a, m, n, k, T, LA>& a,        \
        const fragment<matrix_b, m, n, k, T, LB>& b, const fragment<accumulator, m, n, k, TC>& c,  \
        bool satf = false) {                                                                       \
        RA ra[countA], rb[countB];                                                                 \
        RC rc[countC];                                                                             \
        RD rd[countD];                                                                             \
        __builtin_memcpy(ra, a.x, sizeof ra);                                                      \
        __builtin_memcpy(rb, b.x, sizeof rb);                                                      \
        __builtin_memcpy(rc, c.x, sizeof rc);                                                      \
        if (satf)                                                                                  \
            SUNSTONE_PRODUCT_TEXT("wmma.mma.sync.aligned." #la "." #lb ".m" #m "n" #n              \
                                  "k" #k types saturated,                                          \
                                  countD, countA, countB, countC, CD, CA, CC);                     \
        else                                                                                       \
            SUNSTONE_PRODUCT_TEXT("wmma.mma.sync.aligned." #la "." #lb ".m" #m "n" #n              \
                                  "k" #k types,                                                    \
                                  countD, countA, countB, countC, CD, CA, CC);                     \
        __builtin_memcpy(d.x, rd, sizeof rd);                                                      \
    }
#define SUNSTONE_PRODUCTS(m, n, k, T, ...)                                                         \
    SUNSTONE_PRODUCT(m, n, k, T, row_major, row, row_major, row, __VA_ARGS__)                      \
    SUNSTONE_PRODUCT(m, n, k, T, row_major, row, col_major, col, __VA_ARGS__)                      \
    SUNSTONE_PRODUCT(m, n, k, T, col_major, col, row_major, row, __VA_ARGS__)                      \
    SUNSTONE_PRODUCT(m, n, k, T, col_major, col, col_major, col, __VA_ARGS__)

#define SUNSTONE_SHAPE_PRODUCTS(m, n, k, countA, countB, countBrainA, countBrainB)                 \
    SUNSTONE_PRODUCTS(m, n, k, __half, __half, __half, ".f16.f16", "", unsigned, 8, 8, unsigned,   \
                      4, "r", unsigned, 4, "r", "r")                                               \
    SUNSTONE_PRODUCTS(m, n, k, __half, float, __half, ".f32.f16", "", unsigned, 8, 8, float, 8,    \
                      "f", unsigned, 4, "r", "r")                                                  \
    SUNSTONE_PRODUCTS(m, n, k, __half, __half, float, ".f16.f32", "", unsigned, 8, 8, unsigned, 4, \
                      "r", float, 8, "f", "r")                                                     \
    SUNSTONE_PRODUCTS(m, n, k, __half, float, float, ".f32.f32", "", unsigned, 8, 8, float, 8,     \
                      "f", float, 8, "f", "r")                                                     \
    SUNSTONE_PRODUCTS(m, n, k, __nv_bfloat16, float, float, ".f32.bf16.bf16.f32", "", unsigned,    \
                      countBrainA, countBrainB, float, 8, "f", float, 8, "f", "r")                 \
    SUNSTONE_PRODUCTS(m, n, k, signed char, int, int, ".s32.s8.s8.s32", ".satfinite", unsigned,    \
                      countA, countB, int, 8, "r", int, 8, "r", "r")                               \
    SUNSTONE_PRODUCTS(m, n, k, unsigned char, int, int, ".s32.u8.u8.s32", ".satfinite", unsigned,  \
                      countA, countB, int, 8, "r", int, 8, "r", "r")
SUNSTONE_SHAPE_PRODUCTS(16, 16, 16, 2, 2, 4, 4)
SUNSTONE_SHAPE_PRODUCTS(8, 32, 16, 1, 4, 2, 8)
SUNSTONE_SHAPE_PRODUCTS(32, 8, 16, 4, 1, 8, 2)
SUNSTONE_PRODUCTS(16, 16, 8, precision::tf32, float, float, ".f32.tf32.tf32.f32", "", unsigned, 4,
                  4, float, 8, "f", float, 8, "f", "r")
SUNSTONE_PRODUCTS(8, 8, 4, double, double, double, ".rn.f64.f64.f64.f64", "", double, 1, 1, double,
                  2, "d", double, 2, "d", "d")
SUNSTONE_PRODUCT(8, 8, 32, experimental::precision::s4, row_major, row, col_major, col, int, int,
                 ".s32.s4.s4.s32", ".satfinite", unsigned, 1, 1, int, 2, "r", int, 2, "r", "r")
SUNSTONE_PRODUCT(8, 8, 32, experimental::precision::u4, row_major, row, col_major, col, int, int,
                 ".s32.u4.u4.s32", ".satfinite", unsigned, 1, 1, int, 2, "r", int, 2, "r", "r")

SUNSTONE_DEVICE void
bmma_sync(fragment<accumulator, 8, 8, 128, int>& d,
          const fragment<matrix_a, 8, 8, 128, experimental::precision::b1, row_major>& a,
          const fragment<matrix_b, 8, 8, 128, experimental::precision::b1, col_major>& b,
          const fragment<accumulator, 8, 8, 128, int>& c,
          experimental::bmmaBitOp operation = experimental::bmmaBitOpXOR,
          experimental::bmmaAccumulateOp = experimental::bmmaAccumulateOpPOPC) {
    const unsigned *ra = a.x, *rb = b.x;
    const int* rc = c.x;
    int rd[2];
#if !defined(__CUDA_ARCH__) || __CUDA_ARCH__ >= 800
    if (operation == experimental::bmmaBitOpAND)
        SUNSTONE_PRODUCT_TEXT("wmma.mma.and.popc.sync.aligned.row.col.m8n8k128.s32.b1.b1.s32", 2, 1,
                              1, 2, "r", "r", "r");
    else
#endif
        SUNSTONE_PRODUCT_TEXT("wmma.mma.xor.popc.sync.aligned.row.col.m8n8k128.s32.b1.b1.s32", 2, 1,
                              1, 2, "r", "r", "r");
    (void)operation;
    d.x[0] = rd[0];
    d.x[1] = rd[1];
}

#undef SUNSTONE_PRODUCT
#undef SUNSTONE_PRODUCTS
#undef SUNSTONE_PRODUCT_TEXT
#undef SUNSTONE_SHAPE_PRODUCTS
#undef SUNSTONE_SHAPE
#undef SUNSTONE_SUM
#undef SUNSTONE_FACTORS
#undef SUNSTONE_FACTOR_LAYOUTS
#undef SUNSTONE_FACTOR
#undef SUNSTONE_LOAD_FRAGMENT
#undef SUNSTONE_LIST_1
#undef SUNSTONE_LIST_2
#undef SUNSTONE_LIST_4
#undef SUNSTONE_LIST_8
#undef SUNSTONE_OPERANDS_1
#undef SUNSTONE_OPERANDS_2
#undef SUNSTONE_OPERANDS_4
#undef SUNSTONE_OPERANDS_8

template <class Use, int m, int n, int k, class T, class Layout>
SUNSTONE_DEVICE void
fill_fragment(fragment<Use, m, n, k, T, Layout>& a,
              const typename fragment<Use, m, n, k, T, Layout>::storage_element_type& value) {
    for (int i = 0; i < a.num_storage_elements; ++i)
        a.x[i] = value;
}

// The nearest number with ten bits of fraction, of two the one farther from zero.
SUNSTONE_DEVICE float __float_to_tf32(float value) {
    unsigned result;
    asm("cvt.rna.tf32.f32 %0, %1;" : "=r"(result) : "f"(value));
    return __builtin_bit_cast(float, result);
}

} // namespace wmma
} // namespace nvcuda

#endif
