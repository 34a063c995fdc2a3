// SPDX-License-Identifier: Apache-2.0
// Prefix sums over many blocks: shuffles within a warp, shared memory within a block, a second
// level over the sums of the blocks.
#include <cuda_runtime.h>

#include "check.h"

#include <vector>

constexpr int kThreads = 256;

__device__ unsigned scanWarp(unsigned value) {
    const unsigned lane = threadIdx.x % 32;
    for (unsigned distance = 1; distance < 32; distance *= 2) {
        const unsigned left = __shfl_up_sync(0xffffffffu, value, distance);
        if (lane >= distance)
            value += left;
    }
    return value;
}

// Inclusive prefix sums of each block, and the sum of each block.
__global__ void scanBlocks(const unsigned* in, unsigned* out, unsigned* sums, int n) {
    __shared__ unsigned warpSums[kThreads / 32];
    const int i = blockIdx.x * kThreads + threadIdx.x;
    const unsigned warp = threadIdx.x / 32;
    unsigned value = scanWarp(i < n ? in[i] : 0);
    if (threadIdx.x % 32 == 31)
        warpSums[warp] = value;
    __syncthreads();
    if (warp == 0) {
        const unsigned mine = threadIdx.x < kThreads / 32 ? warpSums[threadIdx.x] : 0;
        const unsigned all = scanWarp(mine);
        if (threadIdx.x < kThreads / 32)
            warpSums[threadIdx.x] = all;
    }
    __syncthreads();
    if (warp > 0)
        value += warpSums[warp - 1];
    if (i < n)
        out[i] = value;
    if (threadIdx.x == kThreads - 1 && sums)
        sums[blockIdx.x] = value;
}

__global__ void addBlockSums(unsigned* out, const unsigned* sums, int n) {
    const int i = blockIdx.x * kThreads + threadIdx.x;
    if (blockIdx.x > 0 && i < n)
        out[i] += sums[blockIdx.x - 1];
}

static void scan(const unsigned* in, unsigned* out, int n) {
    const int blocks = (n + kThreads - 1) / kThreads;
    unsigned* sums = nullptr;
    if (blocks > 1)
        CHECK(cudaMalloc(&sums, blocks * sizeof(unsigned)));
    scanBlocks<<<blocks, kThreads>>>(in, out, sums, n);
    CHECK(cudaGetLastError());
    if (blocks > 1) {
        scan(sums, sums, blocks);
        addBlockSums<<<blocks, kThreads>>>(out, sums, n);
        CHECK(cudaGetLastError());
        CHECK(cudaFree(sums));
    }
}

int main() {
    for (int n : {1, 255, 256, 1000, 100000}) {
        std::vector<unsigned> host(n), result(n);
        for (int i = 0; i < n; ++i)
            host[i] = unsigned(i) * 2654435761u % 1000;
        unsigned *in, *out;
        CHECK(cudaMalloc(&in, n * sizeof(unsigned)));
        CHECK(cudaMalloc(&out, n * sizeof(unsigned)));
        CHECK(cudaMemcpy(in, host.data(), n * sizeof(unsigned), cudaMemcpyHostToDevice));
        scan(in, out, n);
        CHECK(cudaMemcpy(result.data(), out, n * sizeof(unsigned), cudaMemcpyDeviceToHost));
        unsigned sum = 0;
        int wrong = 0;
        for (int i = 0; i < n; ++i)
            wrong += result[i] != (sum += host[i]);
        std::printf("%d values: sum %u, %d wrong\n", n, result[n - 1], wrong);
        CHECK(cudaFree(in));
        CHECK(cudaFree(out));
    }
    return 0;
}
