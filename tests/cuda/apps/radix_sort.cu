// SPDX-License-Identifier: Apache-2.0
// Radix sort of keys with values, four bits at a time: votes rank the keys of a warp, counts of all
// blocks give each block its places.
#include <cuda_runtime.h>

#include "check.h"

#include <vector>

constexpr int kThreads = 128, kWarps = kThreads / 32, kDigits = 16;

// The lanes of this warp whose digit is the same.
__device__ unsigned peersOf(unsigned digit, unsigned active) {
    unsigned peers = active;
    for (int bit = 0; bit < 4; ++bit) {
        const bool set = digit >> bit & 1;
        const unsigned votes = __ballot_sync(0xffffffffu, set);
        peers &= set ? votes : ~votes;
    }
    return peers;
}

// counts[digit * blocks + block]: how many keys of the block have the digit.
__global__ void count(const unsigned* keys, int n, int shift, unsigned* counts) {
    __shared__ unsigned local[kDigits];
    if (threadIdx.x < kDigits)
        local[threadIdx.x] = 0;
    __syncthreads();
    const int i = blockIdx.x * kThreads + threadIdx.x;
    if (i < n)
        atomicAdd(&local[keys[i] >> shift & 15], 1u);
    __syncthreads();
    if (threadIdx.x < kDigits)
        counts[threadIdx.x * gridDim.x + blockIdx.x] = local[threadIdx.x];
}

// One block: turns counts into places, in order.
__global__ void place(unsigned* counts, int n) {
    __shared__ unsigned sums[kThreads];
    const int each = (n + kThreads - 1) / kThreads, first = threadIdx.x * each;
    unsigned sum = 0;
    for (int i = first; i < first + each && i < n; ++i)
        sum += counts[i];
    sums[threadIdx.x] = sum;
    __syncthreads();
    for (int distance = 1; distance < kThreads; distance *= 2) {
        const unsigned left = int(threadIdx.x) >= distance ? sums[threadIdx.x - distance] : 0;
        __syncthreads();
        sums[threadIdx.x] += left;
        __syncthreads();
    }
    unsigned at = sums[threadIdx.x] - sum;
    for (int i = first; i < first + each && i < n; ++i) {
        const unsigned here = counts[i];
        counts[i] = at;
        at += here;
    }
}

__global__ void scatter(const unsigned* keys, const unsigned* values, int n, int shift,
                        const unsigned* places, unsigned* outKeys, unsigned* outValues) {
    __shared__ unsigned perWarp[kWarps][kDigits];
    const int i = blockIdx.x * kThreads + threadIdx.x;
    const unsigned lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    const unsigned key = i < n ? keys[i] : 0, digit = key >> shift & 15;
    const unsigned active = __ballot_sync(0xffffffffu, i < n);
    const unsigned peers = peersOf(digit, active);
    const unsigned rank = __popc(peers & ((1u << lane) - 1));
    if (lane < kDigits)
        perWarp[warp][lane] = 0;
    __syncwarp();
    if (i < n && rank == 0)
        perWarp[warp][digit] = __popc(peers);
    __syncthreads();
    if (i >= n)
        return;
    unsigned before = 0;
    for (unsigned w = 0; w < warp; ++w)
        before += perWarp[w][digit];
    const unsigned to = places[digit * gridDim.x + blockIdx.x] + before + rank;
    outKeys[to] = key;
    outValues[to] = values[i];
}

int main() {
    const int n = 20011, blocks = (n + kThreads - 1) / kThreads;
    std::vector<unsigned> keys(n), values(n);
    unsigned state = 12345;
    for (int i = 0; i < n; ++i) {
        state = state * 1664525u + 1013904223u;
        keys[i] = state >> (i % 3 * 8);
        values[i] = i;
    }
    unsigned *k[2], *v[2], *counts;
    for (int b = 0; b < 2; ++b) {
        CHECK(cudaMalloc(&k[b], n * sizeof(unsigned)));
        CHECK(cudaMalloc(&v[b], n * sizeof(unsigned)));
    }
    CHECK(cudaMalloc(&counts, blocks * kDigits * sizeof(unsigned)));
    CHECK(cudaMemcpy(k[0], keys.data(), n * sizeof(unsigned), cudaMemcpyHostToDevice));
    CHECK(cudaMemcpy(v[0], values.data(), n * sizeof(unsigned), cudaMemcpyHostToDevice));
    for (int shift = 0; shift < 32; shift += 4) {
        count<<<blocks, kThreads>>>(k[0], n, shift, counts);
        place<<<1, kThreads>>>(counts, blocks * kDigits);
        scatter<<<blocks, kThreads>>>(k[0], v[0], n, shift, counts, k[1], v[1]);
        CHECK(cudaGetLastError());
        std::swap(k[0], k[1]);
        std::swap(v[0], v[1]);
    }
    std::vector<unsigned> sorted(n), order(n);
    CHECK(cudaMemcpy(sorted.data(), k[0], n * sizeof(unsigned), cudaMemcpyDeviceToHost));
    CHECK(cudaMemcpy(order.data(), v[0], n * sizeof(unsigned), cudaMemcpyDeviceToHost));
    int unsortedPairs = 0, unstable = 0, lost = 0;
    for (int i = 0; i < n; ++i) {
        lost += order[i] >= unsigned(n) || keys[order[i]] != sorted[i];
        if (i == 0)
            continue;
        unsortedPairs += sorted[i - 1] > sorted[i];
        unstable += sorted[i - 1] == sorted[i] && order[i - 1] > order[i];
    }
    std::printf("%d keys: %d out of order, %d unstable, %d lost\n", n, unsortedPairs, unstable,
                lost);
    std::printf("first %u, middle %u, last %u\n", sorted[0], sorted[n / 2], sorted[n - 1]);
    return 0;
}
