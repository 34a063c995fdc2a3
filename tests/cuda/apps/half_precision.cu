// SPDX-License-Identifier: Apache-2.0
// Numbers of 16 bits: every function of cuda_fp16.h and cuda_bf16.h over all numbers. Exactly
// rounded functions are printed as a sum over the bits of all results, on device and host;
// mathematics is compared with functions of floats.
#include "check.h"

#include <cuda_bf16.h>
#include <cuda_fp16.h>

namespace {

constexpr unsigned kCount = 65536;

// Sums do not depend on the order of threads. All NaN are one.
template <class T>
__host__ __device__ unsigned long long mixed(T result, unsigned index) {
    unsigned long long bits = 0;
    memcpy(&bits, &result, sizeof result);
    bits = (bits ^ (unsigned long long)index << 32) * 0x9e3779b97f4a7c15ull;
    return (bits ^ bits >> 29) * 0xbf58476d1ce4e5b9ull >> 7;
}
__host__ __device__ unsigned long long mixedNumber(__half x, unsigned index) {
    return mixed(__hisnan(x) ? (unsigned short)0x7fff : __half_as_ushort(x), index);
}
__host__ __device__ unsigned long long mixedNumber(__nv_bfloat16 x, unsigned index) {
    return mixed(__hisnan(x) ? (unsigned short)0x7fff : __bfloat16_as_ushort(x), index);
}
template <class Pair>
__host__ __device__ unsigned long long mixedPair(Pair x, unsigned index) {
    return mixedNumber(x.x, index) + 3 * mixedNumber(x.y, index);
}

// Partners of a number: all of them in another order, near numbers, and limits.
__host__ __device__ unsigned short partner(unsigned i, unsigned round) {
    return (unsigned short)(round == 0   ? i * 40503u + 17
                            : round == 1 ? i ^ (i * 7 & 0x8003)
                            : round == 2 ? 0x3c00 + (i * 31 & 0x1ff)
                                         : (i * 5 & 1 ? 0x8000 : 0) | (i >> 3 & 1 ? 0x0003 : 0x7800));
}

#define CONVERSIONS(X, H)                                                                          \
    X(to_float, mixed(__##H##2float(a) == __##H##2float(a) ? __##H##2float(a) : 0.0f, i))          \
    X(rn, mixedNumber(__float2##H##_rn(wide), i))                                                  \
    X(rz, mixedNumber(__float2##H##_rz(wide), i))                                                  \
    X(rd, mixedNumber(__float2##H##_rd(wide), i))                                                  \
    X(ru, mixedNumber(__float2##H##_ru(wide), i))                                                  \
    X(double2, mixedNumber(__double2##H(wide * 1.0000001), i))                                     \
    X(int_rz, mixed(__##H##2int_rz(a), i))                                                         \
    X(uint_rz, mixed(__##H##2uint_rz(a), i))                                                       \
    X(short_rz, mixed(__##H##2short_rz(a), i))                                                     \
    X(ushort_rz, mixed(__##H##2ushort_rz(a), i))                                                   \
    X(ll_rz, mixed(__##H##2ll_rz(a), i))                                                           \
    X(ull_rz, mixed(__##H##2ull_rz(a), i))                                                         \
    X(char_rz, mixed(__##H##2char_rz(a), i))                                                       \
    X(uchar_rz, mixed(__##H##2uchar_rz(a), i))                                                     \
    X(from_int_rn, mixedNumber(__int2##H##_rn(number), i))                                         \
    X(from_uint_rn, mixedNumber(__uint2##H##_rn(unsigned(number)), i))                             \
    X(from_short_rn, mixedNumber(__short2##H##_rn(short(i)), i))                                   \
    X(from_ushort_rn, mixedNumber(__ushort2##H##_rn((unsigned short)i), i))                        \
    X(from_ll_rn, mixedNumber(__ll2##H##_rn(large), i))                                            \
    X(from_ull_rn, mixedNumber(__ull2##H##_rn((unsigned long long)large), i))
// In device code alone.
#define DEVICE_CONVERSIONS(X, H)                                                                   \
    X(int_rn, mixed(__##H##2int_rn(a), i))                                                         \
    X(int_rd, mixed(__##H##2int_rd(a), i))                                                         \
    X(int_ru, mixed(__##H##2int_ru(a), i))                                                         \
    X(from_int_rz, mixedNumber(__int2##H##_rz(number), i))                                         \
    X(from_int_rd, mixedNumber(__int2##H##_rd(number), i))                                         \
    X(from_int_ru, mixedNumber(__int2##H##_ru(number), i))                                         \
    X(uint_rn, mixed(__##H##2uint_rn(a), i))                                                       \
    X(uint_rd, mixed(__##H##2uint_rd(a), i))                                                       \
    X(uint_ru, mixed(__##H##2uint_ru(a), i))                                                       \
    X(from_uint_rz, mixedNumber(__uint2##H##_rz(unsigned(number)), i))                             \
    X(from_uint_rd, mixedNumber(__uint2##H##_rd(unsigned(number)), i))                             \
    X(from_uint_ru, mixedNumber(__uint2##H##_ru(unsigned(number)), i))                             \
    X(short_rn, mixed(__##H##2short_rn(a), i))                                                     \
    X(short_rd, mixed(__##H##2short_rd(a), i))                                                     \
    X(short_ru, mixed(__##H##2short_ru(a), i))                                                     \
    X(from_short_rz, mixedNumber(__short2##H##_rz(short(i)), i))                                   \
    X(from_short_rd, mixedNumber(__short2##H##_rd(short(i)), i))                                   \
    X(from_short_ru, mixedNumber(__short2##H##_ru(short(i)), i))                                   \
    X(ushort_rn, mixed(__##H##2ushort_rn(a), i))                                                   \
    X(ushort_rd, mixed(__##H##2ushort_rd(a), i))                                                   \
    X(ushort_ru, mixed(__##H##2ushort_ru(a), i))                                                   \
    X(from_ushort_rz, mixedNumber(__ushort2##H##_rz((unsigned short)i), i))                        \
    X(from_ushort_rd, mixedNumber(__ushort2##H##_rd((unsigned short)i), i))                        \
    X(from_ushort_ru, mixedNumber(__ushort2##H##_ru((unsigned short)i), i))                        \
    X(ll_rn, mixed(__##H##2ll_rn(a), i))                                                           \
    X(ll_rd, mixed(__##H##2ll_rd(a), i))                                                           \
    X(ll_ru, mixed(__##H##2ll_ru(a), i))                                                           \
    X(from_ll_rz, mixedNumber(__ll2##H##_rz(large), i))                                            \
    X(from_ll_rd, mixedNumber(__ll2##H##_rd(large), i))                                            \
    X(from_ll_ru, mixedNumber(__ll2##H##_ru(large), i))                                            \
    X(ull_rn, mixed(__##H##2ull_rn(a), i))                                                         \
    X(ull_rd, mixed(__##H##2ull_rd(a), i))                                                         \
    X(ull_ru, mixed(__##H##2ull_ru(a), i))                                                         \
    X(from_ull_rz, mixedNumber(__ull2##H##_rz((unsigned long long)large), i))                      \
    X(from_ull_rd, mixedNumber(__ull2##H##_rd((unsigned long long)large), i))                      \
    X(from_ull_ru, mixedNumber(__ull2##H##_ru((unsigned long long)large), i))

#define ARITHMETIC(X)                                                                              \
    X(add, mixedNumber(__hadd_rn(a, b), i))                                                        \
    X(sub, mixedNumber(__hsub_rn(a, b), i))                                                        \
    X(mul, mixedNumber(__hmul_rn(a, b), i))                                                        \
    X(div, mixedNumber(__hdiv(a, b), i))                                                           \
    X(add_sat, mixedNumber(__hadd_sat(a, b), i))                                                   \
    X(sub_sat, mixedNumber(__hsub_sat(a, b), i))                                                   \
    X(mul_sat, mixedNumber(__hmul_sat(a, b), i))                                                   \
    X(neg, mixedNumber(__hneg(a), i))                                                              \
    X(abs, mixedNumber(__habs(a), i))                                                              \
    X(max, mixedNumber(__hmax(a, b), i))                                                           \
    X(min, mixedNumber(__hmin(a, b), i))                                                           \
    X(compare, mixed(__heq(a, b) | __hne(a, b) << 1 | __hlt(a, b) << 2 | __hle(a, b) << 3 |        \
      __hgt(a, b) << 4 | __hge(a, b) << 5, i))                                                     \
    X(compare_u, mixed(__hequ(a, b) | __hneu(a, b) << 1 | __hltu(a, b) << 2 |                      \
      __hleu(a, b) << 3 | __hgtu(a, b) << 4 | __hgeu(a, b) << 5, i))                               \
    X(classes, mixed(__hisnan(a) | (__hisinf(a) + 1) << 1, i))                                     \
    X(add2, mixedPair(__hadd2_rn(p, q), i))                                                        \
    X(mul2, mixedPair(__hmul2_rn(p, q), i))                                                        \
    X(div2, mixedPair(__h2div(p, q), i))                                                           \
    X(max2, mixedPair(__hmax2(p, q), i))                                                           \
    X(neg2, mixedPair(__hneg2(p), i))                                                              \
    X(eq2, mixedPair(__heq2(p, q), i))                                                             \
    X(ltu2_mask, mixed(__hltu2_mask(p, q), i))                                                     \
    X(ge2, mixed(__hbge2(p, q), i))                                                                \
    X(operators, mixedNumber(-(a / b), i) + mixed(a < b, i) + mixed(a != b, i) +                   \
      mixed(p == q, i))                                                                            \
    X(swap, mixedPair(__lowhigh2highlow(p), i))
// In device code alone, or elsewhere not the same in all toolkits.
#define DEVICE_ARITHMETIC(X)                                                                       \
    X(max_nan, mixedNumber(__hmax_nan(a, b), i))                                                   \
    X(min_nan, mixedNumber(__hmin_nan(a, b), i))                                                   \
    X(fma, mixedNumber(__hfma(a, b, c), i))                                                        \
    X(fma_sat, mixedNumber(__hfma_sat(a, b, c), i))                                                \
    X(fma2, mixedPair(__hfma2(p, q, r), i))                                                        \
    X(complex, mixedPair(__hcmadd(p, q, r), i))

#define MATHEMATICS(X)                                                                             \
    X(sqrt, sqrtf)                                                                                 \
    X(rsqrt, rsqrtf)                                                                               \
    X(rcp, reciprocal)                                                                             \
    X(exp, expf)                                                                                   \
    X(exp2, exp2f)                                                                                 \
    X(exp10, exp10f)                                                                               \
    X(log, logf)                                                                                   \
    X(log2, log2f)                                                                                 \
    X(log10, log10f)                                                                               \
    X(sin, sinf)                                                                                   \
    X(cos, cosf)                                                                                   \
    X(tanh, tanhf)                                                                                 \
    X(ceil, ceilf)                                                                                 \
    X(floor, floorf)                                                                               \
    X(trunc, truncf)                                                                               \
    X(rint, rintf)

__device__ float reciprocal(float x) {
    return 1.0f / x;
}

struct Half {
    using Number = __half;
    using Pair = __half2;
    static __host__ __device__ Number of(unsigned short bits) { return __ushort_as_half(bits); }
    static __host__ __device__ Pair pair(Number a, Number b) { return __halves2half2(a, b); }
    static __host__ __device__ int order(Number x) { return ordered(__half_as_ushort(x)); }
    static __host__ __device__ int ordered(unsigned short bits) {
        return bits & 0x8000 ? -int(bits & 0x7fff) : int(bits);
    }
    static __host__ __device__ Number near(float x) { return __float2half_rn(x); }
};
struct Bfloat16 {
    using Number = __nv_bfloat16;
    using Pair = __nv_bfloat162;
    static __host__ __device__ Number of(unsigned short bits) { return __ushort_as_bfloat16(bits); }
    static __host__ __device__ Pair pair(Number a, Number b) { return __halves2bfloat162(a, b); }
    static __host__ __device__ int order(Number x) { return Half::ordered(__bfloat16_as_ushort(x)); }
    static __host__ __device__ Number near(float x) { return __float2bfloat16_rn(x); }
};

constexpr int kMost = 80;

#define SUM(name, value) sums[k++] += value;
#define NAME(name, value) #name,
#define OPERANDS(Format)                                                                           \
    const typename Format::Number a = Format::of((unsigned short)i),                               \
                                  b = Format::of(partner(i, round)),                               \
                                  c = Format::of(partner(i * 3 + 1, round ^ 1));                   \
    const typename Format::Pair p = Format::pair(a, b), q = Format::pair(b, c),                    \
                                r = Format::pair(c, a);

template <class Format>
__host__ __device__ void arithmetic(unsigned i, unsigned round, unsigned long long* sums) {
    OPERANDS(Format)
    int k = 0;
    ARITHMETIC(SUM)
#ifdef __CUDA_ARCH__
    DEVICE_ARITHMETIC(SUM)
#endif
}
#define INPUTS                                                                                     \
    const unsigned scrambled = i * 65537u + round * 0x12345u;                                      \
    float wide;                                                                                    \
    memcpy(&wide, &scrambled, sizeof wide);                                                        \
    if (round > 1)                                                                                 \
        wide = float(int(i) - 32768) * (round == 2 ? 3.0517578e-8f : 3.1415926f);                  \
    const int number = int(i * 40503u) >> (i & 15);                                                \
    const long long large = (long long)(i * 0x9e3779b97f4a7c15ull) >> (i & 31);                    \
    int k = 0;
template <class Format>
__host__ __device__ void conversions(unsigned i, unsigned round, unsigned long long* sums);
template <>
__host__ __device__ void conversions<Half>(unsigned i, unsigned round, unsigned long long* sums) {
    const __half a = __ushort_as_half((unsigned short)i);
    INPUTS
    CONVERSIONS(SUM, half)
#ifdef __CUDA_ARCH__
    DEVICE_CONVERSIONS(SUM, half)
#endif
}
template <>
__host__ __device__ void conversions<Bfloat16>(unsigned i, unsigned round,
                                               unsigned long long* sums) {
    const __nv_bfloat16 a = __ushort_as_bfloat16((unsigned short)i);
    INPUTS
    CONVERSIONS(SUM, bfloat16)
#ifdef __CUDA_ARCH__
    DEVICE_CONVERSIONS(SUM, bfloat16)
#endif
}

template <class Format>
__global__ void arithmeticOf(unsigned round, unsigned long long* total) {
    unsigned long long sums[kMost] = {};
    arithmetic<Format>(blockIdx.x * blockDim.x + threadIdx.x, round, sums);
    for (int k = 0; k < kMost; ++k)
        if (sums[k])
            atomicAdd(total + k, sums[k]);
}
template <class Format>
__global__ void conversionsOf(unsigned round, unsigned long long* total) {
    unsigned long long sums[kMost] = {};
    conversions<Format>(blockIdx.x * blockDim.x + threadIdx.x, round, sums);
    for (int k = 0; k < kMost; ++k)
        if (sums[k])
            atomicAdd(total + k, sums[k]);
}

// The largest distance between a function and the rounded one of floats, in steps of the format.
template <class Format>
__global__ void mathematics(int* apart) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    const typename Format::Number a = Format::of((unsigned short)i);
    const float x = float(a);
    int k = 0;
#define APART(name, function)                                                                      \
    {                                                                                              \
        const typename Format::Number got = h##name(a), expected = Format::near(function(x));      \
        const typename Format::Pair both = h2##name(Format::pair(a, a));                           \
        int distance = abs(Format::order(got) - Format::order(expected));                          \
        if (__hisnan(got) || __hisnan(expected))                                                   \
            distance = __hisnan(got) && __hisnan(expected) ? 0 : 99999;                            \
        if (!(__heq(both.x, got) && __heq(both.y, got)) && !__hisnan(got))                         \
            distance = 88888;                                                                      \
        atomicMax(apart + k++, distance);                                                          \
    }
    MATHEMATICS(APART)
}

template <class Number, class Pair>
__global__ void together(Number* number, Pair* pair, Number* rotated, Pair* loaded) {
    atomicAdd(number, Number(1.0f));
    atomicAdd(number + 1, Number(0.5f));
    atomicAdd(pair, Pair(Number(1.0f), Number(-0.25f)));
    const Number mine = Number(float(threadIdx.x));
    rotated[threadIdx.x] = __shfl_sync(0xffffffffu, mine, int(threadIdx.x + 1) & 31);
    const Pair two(mine, -mine);
    __stcg(loaded + threadIdx.x, __shfl_xor_sync(0xffffffffu, two, 1));
    if (float(__ldg(rotated + threadIdx.x)) != float(int(threadIdx.x + 1) & 31))
        rotated[threadIdx.x] = Number(-1.0f);
}

template <class Format>
void run(const char* format) {
    unsigned long long* sums;
    CHECK(cudaMallocManaged(&sums, kMost * sizeof *sums));
    const char* const arithmeticNames[] = {ARITHMETIC(NAME) DEVICE_ARITHMETIC(NAME)};
    const char* const conversionNames[] = {CONVERSIONS(NAME, ) DEVICE_CONVERSIONS(NAME, )};
    const auto print = [&](const char* const* names, int count, const unsigned long long* host) {
        for (int k = 0; k < count; ++k)
            printf("%s %s: %016llx, %s\n", format, names[k], sums[k],
                   host[k] == 0         ? "device only"
                   : host[k] == sums[k] ? "as on the host" : "other than on the host");
    };
    unsigned long long host[kMost] = {};
    memset(sums, 0, kMost * sizeof *sums);
    for (unsigned round = 0; round < 2; ++round) {
        arithmeticOf<Format><<<kCount / 256, 256>>>(round, sums);
        for (unsigned i = 0; i < kCount; ++i)
            arithmetic<Format>(i, round, host);
    }
    CHECK(cudaDeviceSynchronize());
    print(arithmeticNames, sizeof arithmeticNames / sizeof *arithmeticNames, host);
    memset(sums, 0, kMost * sizeof *sums);
    memset(host, 0, sizeof host);
    for (unsigned round = 0; round < 2; ++round) {
        conversionsOf<Format><<<kCount / 256, 256>>>(round, sums);
        for (unsigned i = 0; i < kCount; ++i)
            conversions<Format>(i, round, host);
    }
    CHECK(cudaDeviceSynchronize());
    print(conversionNames, sizeof conversionNames / sizeof *conversionNames, host);

    int* apart;
    CHECK(cudaMallocManaged(&apart, kMost * sizeof *apart));
    memset(apart, 0, kMost * sizeof *apart);
    mathematics<Format><<<kCount / 256, 256>>>(apart);
    CHECK(cudaDeviceSynchronize());
#define PLAIN(name, function) #name,
    const char* const functions[] = {MATHEMATICS(PLAIN)};
    for (size_t k = 0; k < sizeof functions / sizeof *functions; ++k)
        if (apart[k] > 1) // the vendor's functions may differ by one step
            printf("%s h%s is %d steps away\n", format, functions[k], apart[k]);

    typename Format::Number *number, *rotated;
    typename Format::Pair *pair, *loaded;
    CHECK(cudaMallocManaged(&number, 4));
    CHECK(cudaMallocManaged(&pair, 4));
    CHECK(cudaMallocManaged(&rotated, 64));
    CHECK(cudaMallocManaged(&loaded, 128));
    memset(number, 0, 4);
    memset(pair, 0, 4);
    together<<<1, 32>>>(number, pair, rotated, loaded);
    CHECK(cudaDeviceSynchronize());
    printf("%s atomics: %g %g, %g %g; shuffles: %g %g %g\n", format, float(number[0]),
           float(number[1]), float(pair->x), float(pair->y), float(rotated[31]), float(loaded[4].x),
           float(loaded[4].y));
}

} // namespace

int main() {
    run<Half>("half");
    run<Bfloat16>("bfloat16");
    return 0;
}
