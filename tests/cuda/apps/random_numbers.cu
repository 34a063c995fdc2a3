// SPDX-License-Identifier: Apache-2.0
// Generators of curand_kernel.h: seeds, subsequences and offsets; numbers of every distribution.
// Integers and uniform numbers are exact; normal numbers are printed with the digits that do not
// depend on rounding in logarithms and roots. The expected text was printed by the program built
// with CUDA 13.0's own header, as nvcc builds it where that header is installed.
#include <curand_kernel.h>

#include <cstdio>

// Direction vectors of the first dimensions: Joe and Kuo 2008, "Constructing Sobol sequences with
// better two-dimensional projections", from the degrees, coefficients and first numbers they list.
struct Dimension {
    int degree, coefficients;
    unsigned first[5];
};
constexpr int kDimensions = 5;
__constant__ Dimension dimensions[kDimensions] = {
    {0, 0, {}}, {1, 0, {1}}, {2, 1, {1, 3}}, {4, 4, {1, 3, 5, 13}}, {5, 7, {1, 1, 7, 11, 19}}};

template <class Word>
__device__ __noinline__ void makeVectors(int number, Word* v) {
    const Dimension& d = dimensions[number];
    const int bits = 8 * sizeof(Word), s = d.degree;
    for (int i = 0; i < bits; ++i) {
        if (s == 0 || i < s) {
            v[i] = Word(s == 0 ? 1 : d.first[i]) << (bits - 1 - i);
            continue;
        }
        v[i] = v[i - s] ^ (v[i - s] >> s);
        for (int k = 1; k < s; ++k)
            if ((d.coefficients >> (s - 1 - k)) & 1)
                v[i] ^= v[i - k];
    }
}

template <class State>
__device__ __noinline__ void printBits(const char* name, State state) {
    printf("%s:", name);
    for (int i = 0; i < 6; ++i)
        printf(" %llx", (unsigned long long)curand(&state));
    printf("\n");
}
template <class State>
__device__ __noinline__ void printNumbers(const State& state) {
    State copy = state;
    printf("  uniform");
    for (int i = 0; i < 4; ++i)
        printf(" %a", curand_uniform(&copy));
    copy = state;
    printf("\n  double");
    for (int i = 0; i < 3; ++i)
        printf(" %a", curand_uniform_double(&copy));
    copy = state;
    printf("\n  normal");
    for (int i = 0; i < 5; ++i)
        printf(" %.4f", curand_normal(&copy));
    copy = state;
    printf("\n  double");
    for (int i = 0; i < 3; ++i)
        printf(" %.9f", curand_normal_double(&copy));
    printf(" then %llx\n", (unsigned long long)curand(&copy));
    copy = state;
    printf("  log-normal %.4f", curand_log_normal(&copy, 0.5f, 0.25f));
    printf(" %.9f\n", curand_log_normal_double(&copy, -1.0, 0.75));
}
template <class State>
__device__ __noinline__ void printPairs(State state) {
    const float2 pair = curand_normal2(&state);
    const double2 wide = curand_normal2_double(&state);
    const float2 other = curand_log_normal2(&state, 0.1f, 0.2f);
    printf("  pairs %.4f %.4f %.9f %.9f %.4f %.4f\n", pair.x, pair.y, wide.x, wide.y, other.x,
           other.y);
}

template <class State>
__device__ __noinline__ void seeded(const char* name) {
    printf("%s\n", name);
    State state;
    const unsigned long long seeds[] = {0, 1, 0x100000000ull, 0x123456789abcdefull};
    for (unsigned long long seed : seeds) {
        curand_init(seed, 0, 0, &state);
        printBits("seed", state);
    }
    const unsigned long long places[][2] = {
        {1, 0},       {2, 7},
        {0, 1},       {0, 2},
        {0, 3},       {0, 1000},
        {12345, 678}, {0x7edcba9876543ull, 0x123456789abcdefull},
        {0, ~0ull},   {0x7ffffffffffffull, 5}}; // MRG32k3a has 2^51 subsequences
    for (const auto& place : places) {
        curand_init(1234, place[0], place[1], &state);
        printBits("place", state);
    }
    curand_init(99, 3, 5, &state);
    skipahead(77, &state);
    printBits("ahead", state);
    skipahead_sequence(9, &state);
    printBits("sequences", state);
    curand_init(2024, 0, 0, &state);
    printNumbers(state);
    printPairs(state);
}

template <class State, class Word>
__device__ __noinline__ void sobol(const char* name) {
    for (int number = 0; number < kDimensions; ++number) {
        Word vectors[8 * sizeof(Word)];
        makeVectors(number, vectors);
        State state;
        curand_init(vectors, Word(0), &state);
        printBits(name, state);
        curand_init(vectors, Word(1000 + number), &state);
        printBits("  offset", state);
        skipahead(Word(77), &state);
        printBits("  ahead", state);
        printNumbers(state);
    }
}
template <class State, class Word>
__device__ __noinline__ void scrambled(const char* name) {
    for (int number = 0; number < kDimensions; ++number) {
        Word vectors[8 * sizeof(Word)];
        makeVectors(number, vectors);
        State state;
        curand_init(vectors, Word(0x9e3779b97f4a7c15ull * (number + 1)), Word(5), &state);
        printBits(name, state);
        printNumbers(state);
    }
}

__global__ void numbers() {
    seeded<curandStateXORWOW_t>("XORWOW");
    seeded<curandStatePhilox4_32_10_t>("Philox");
    seeded<curandStateMRG32k3a_t>("MRG32k3a");
    sobol<curandStateSobol32_t, unsigned>("Sobol32");
    scrambled<curandStateScrambledSobol32_t, unsigned>("scrambled Sobol32");
    sobol<curandStateSobol64_t, unsigned long long>("Sobol64");
    scrambled<curandStateScrambledSobol64_t, unsigned long long>("scrambled Sobol64");
}

// Four at a time, and subsequences of MRG32k3a.
__global__ void groups() {
    curandStatePhilox4_32_10_t state;
    for (int offset = 0; offset < 4; ++offset) {
        curand_init(7, 0, offset, &state);
        const uint4 x = curand4(&state);
        const float4 u = curand_uniform4(&state), n = curand_normal4(&state),
                     l = curand_log_normal4(&state, 0.5f, 0.5f);
        const double2 d = curand_uniform2_double(&state);
        printf("four %x %x %x %x, %a %a %a %a, %.4f %.4f %.4f %.4f, %.4f %.4f %.4f %.4f, %a %a\n",
               x.x, x.y, x.z, x.w, u.x, u.y, u.z, u.w, n.x, n.y, n.z, n.w, l.x, l.y, l.z, l.w, d.x,
               d.y);
        printBits("then", state);
    }
    curandStateMRG32k3a_t other;
    curand_init(5, 0, 0, &other);
    skipahead_subsequence(3, &other);
    printBits("subsequences", other);
}

// Poisson numbers: mean and variance of many. Values are an implementation's own.
__global__ void poisson(double mean, float* sums) {
    curandState state;
    curand_init(42, threadIdx.x, 0, &state);
    float sum = 0, squares = 0;
    for (int i = 0; i < 250; ++i) {
        const float d = float(curand_poisson(&state, mean) - mean);
        sum += d;
        squares += d * d;
    }
    atomicAdd(&sums[0], sum);
    atomicAdd(&sums[1], squares);
}

int main() {
    numbers<<<1, 1>>>();
    groups<<<1, 1>>>();
    float* sums;
    cudaMallocManaged(&sums, 2 * sizeof(float));
    const double means[] = {0.3, 7.0, 60.0, 150.0, 900.0, 5000.0};
    for (double mean : means) {
        sums[0] = sums[1] = 0;
        poisson<<<1, 128>>>(mean, sums);
        cudaDeviceSynchronize();
        const double count = 128 * 250, off = sums[0] / count;
        const double spread = (sums[1] / count - off * off) / mean;
        // Five standard deviations.
        const bool right = off * off < 25 * mean / count && spread > 0.94 && spread < 1.06;
        printf("Poisson %g: %s\n", mean, right ? "right" : "wrong");
        if (!right)
            printf("  off %g, spread %g\n", off, spread);
    }
    printf("%s\n", cudaGetErrorName(cudaDeviceSynchronize()));
    return 0;
}
