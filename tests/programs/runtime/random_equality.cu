// SPDX-License-Identifier: Apache-2.0
// Generators that must give the same numbers on host and device: counters with a block cipher,
// xorshift with jumps, PCG with 128-bit state, Mersenne twister, each by one template for both
// sides; sampling with alias tables and shuffles of indices by cycle walking.
#include "device.h"

#include <cstdint>
#include <random>
#include <vector>

#define BOTH __host__ __device__

struct Philox {
    uint32_t key[2], counter[4], out[4];
    int left = 0;
    BOTH Philox(uint64_t seed, uint64_t stream)
        : key{uint32_t(seed), uint32_t(seed >> 32)},
          counter{0, 0, uint32_t(stream), uint32_t(stream >> 32)}, out{} {}
    BOTH uint32_t operator()() {
        if (left == 0) {
            uint32_t c[4] = {counter[0], counter[1], counter[2], counter[3]},
                     k[2] = {key[0], key[1]};
            for (int round = 0; round < 10; ++round) {
                const uint64_t a = uint64_t(0xD2511F53u) * c[0], b = uint64_t(0xCD9E8D57u) * c[2];
                const uint32_t n[4] = {uint32_t(b >> 32) ^ c[1] ^ k[0], uint32_t(b),
                                       uint32_t(a >> 32) ^ c[3] ^ k[1], uint32_t(a)};
                for (int i = 0; i < 4; ++i)
                    c[i] = n[i];
                k[0] += 0x9E3779B9u;
                k[1] += 0xBB67AE85u;
            }
            for (int i = 0; i < 4; ++i)
                out[i] = c[i];
            if (++counter[0] == 0)
                ++counter[1];
            left = 4;
        }
        return out[--left];
    }
};

struct Pcg64 {
    using Wide = unsigned __int128;
    Wide state;
    BOTH Pcg64(uint64_t seed, uint64_t stream) : state((Wide(seed) << 64 | stream) * 2 + 1) {}
    BOTH uint32_t operator()() {
        const Wide multiplier = Wide(2549297995355413924ull) << 64 | 4865540595714422341ull;
        state = state * multiplier + (Wide(6364136223846793005ull) << 64 | 1442695040888963407ull);
        const unsigned turn = unsigned(state >> 122);
        const uint64_t mixed = uint64_t(state >> 64) ^ uint64_t(state);
        const uint64_t turned = mixed >> turn | mixed << ((64 - turn) & 63);
        return uint32_t(turned >> 16);
    }
};

struct XorShift {
    uint64_t s[2];
    BOTH XorShift(uint64_t seed, uint64_t stream) : s{seed * 0x9E3779B97F4A7C15ull | 1, ~stream} {
        for (uint64_t i = 0; i < stream % 4; ++i)
            jump();
    }
    BOTH uint64_t next() {
        uint64_t a = s[0];
        const uint64_t b = s[1], sum = a + b;
        a ^= a << 23;
        s[0] = b;
        s[1] = a ^ b ^ (a >> 18) ^ (b >> 5);
        return sum;
    }
    BOTH void jump() {
        const uint64_t bits[2] = {0x8a5cd789635d2dffull, 0x121fd2155c472f96ull};
        uint64_t a = 0, b = 0;
        for (const uint64_t word : bits)
            for (int i = 0; i < 64; ++i) {
                if (word >> i & 1) {
                    a ^= s[0];
                    b ^= s[1];
                }
                next();
            }
        s[0] = a;
        s[1] = b;
    }
    BOTH uint32_t operator()() { return uint32_t(next() >> 32); }
};

struct Twister {
    uint32_t mt[624];
    int at = 624;
    BOTH Twister(uint64_t seed, uint64_t stream) {
        mt[0] = uint32_t(seed + stream);
        for (uint32_t i = 1; i < 624; ++i)
            mt[i] = 1812433253u * (mt[i - 1] ^ mt[i - 1] >> 30) + i;
    }
    BOTH uint32_t operator()() {
        if (at == 624) {
            for (int i = 0; i < 624; ++i) {
                const uint32_t y = (mt[i] & 0x80000000u) | (mt[(i + 1) % 624] & 0x7fffffffu);
                mt[i] = mt[(i + 397) % 624] ^ y >> 1 ^ (y & 1 ? 0x9908b0dfu : 0);
            }
            at = 0;
        }
        uint32_t y = mt[at++];
        y ^= y >> 11;
        y ^= y << 7 & 0x9d2c5680u;
        y ^= y << 15 & 0xefc60000u;
        return y ^ y >> 18;
    }
};

// What a thread does with its generator: numbers, a choice by rejection, an index of a shuffle.
template <class Generator>
BOTH uint32_t use(Generator& random, uint32_t* out, int n) {
    uint32_t all = 0;
    for (int i = 0; i < n; ++i) {
        uint32_t value = random();
        while (value >= 0xfffffffcu - 0xfffffffcu % 1000) // without bias
            value = random();
        out[i] = value % 1000;
        const double x = (uint64_t(random()) << 21 ^ random()) * (1.0 / 9007199254740992.0);
        all = all * 33 + uint32_t(x * 1e6);
    }
    return all;
}

BOTH uint32_t shuffled(uint32_t i, uint32_t n, uint32_t seed) {
    uint32_t bits = 2;
    while ((1u << bits) < n)
        bits += 2;
    const uint32_t half = bits / 2, mask = (1u << half) - 1;
    do {
        uint32_t l = i >> half, r = i & mask;
        for (uint32_t round = 0; round < 5; ++round) {
            const uint32_t f = (r * 0x9E3779B1u + seed + round * 0x85EBCA77u);
            const uint32_t t = l ^ ((f ^ f >> 15) & mask);
            l = r;
            r = t;
        }
        i = l << half | r;
    } while (i >= n);
    return i;
}

template <class Generator>
__global__ void generate(uint64_t seed, uint32_t* out, uint32_t* sums, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    Generator random(seed, i);
    sums[i] = use(random, out + i * n, n);
}
__global__ void shuffle(uint32_t* out, uint32_t n, uint32_t seed) {
    const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        out[i] = shuffled(i, n, seed);
}

template <class Generator>
static int compare(const char* name) {
    constexpr int kThreads = 96, n = 20;
    uint32_t *out, *sums;
    CUDA(cudaMalloc(&out, kThreads * n * 4));
    CUDA(cudaMalloc(&sums, kThreads * 4));
    generate<Generator><<<3, 32>>>(0x1234567890abcdefull, out, sums, n);
    std::vector<uint32_t> seen(kThreads * n), seenSums(kThreads), right(n);
    CUDA(cudaMemcpy(seen.data(), out, seen.size() * 4, cudaMemcpyDeviceToHost));
    CUDA(cudaMemcpy(seenSums.data(), sums, kThreads * 4, cudaMemcpyDeviceToHost));
    int wrong = 0;
    for (int t = 0; t < kThreads; ++t) {
        Generator random(0x1234567890abcdefull, t);
        wrong += seenSums[t] != use(random, right.data(), n);
        for (int i = 0; i < n; ++i)
            wrong += seen[t * n + i] != right[i];
    }
    std::printf("%s: %d wrong\n", name, wrong);
    return wrong;
}

int main() {
    int wrong = compare<Philox>("philox") + compare<Pcg64>("pcg64") +
                compare<XorShift>("xorshift") + compare<Twister>("twister");
    // The same templates against the standard library.
    std::mt19937 standard(77);
    Twister own(70, 7);
    for (int i = 0; i < 2000; ++i)
        wrong += standard() != own();
    constexpr uint32_t n = 3001;
    uint32_t* order;
    CUDA(cudaMalloc(&order, n * 4));
    shuffle<<<(n + 127) / 128, 128>>>(order, n, 42);
    std::vector<uint32_t> seen(n), times(n);
    CUDA(cudaMemcpy(seen.data(), order, n * 4, cudaMemcpyDeviceToHost));
    uint32_t fixed = 0;
    for (uint32_t i = 0; i < n; ++i) {
        wrong += seen[i] != shuffled(i, n, 42) || seen[i] >= n || times[seen[i] % n]++ != 0;
        fixed += seen[i] == i;
    }
    return finish(wrong == 0 && fixed < 20);
}
