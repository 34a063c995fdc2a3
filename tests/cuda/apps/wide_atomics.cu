// SPDX-License-Identifier: Apache-2.0
// Atomics on 128 bits: each thread adds to two counters at once by compare-and-swap, and pairs
// passed on by an exchange are never torn.
#include <cuda_runtime.h>

#include "check.h"

struct alignas(16) Pair {
    unsigned long long first, second;
};

__global__ void add(Pair* total) {
    const unsigned long long own = blockIdx.x * blockDim.x + threadIdx.x;
    Pair old = {0, 0};
    for (;;) {
        const Pair seen = atomicCAS(total, old, Pair{old.first + own, old.second + 1});
        if (seen.first == old.first && seen.second == old.second)
            return;
        old = seen;
    }
}

__global__ void exchange(Pair* place, unsigned long long* sum, int* torn) {
    __shared__ Pair shared;
    if (threadIdx.x == 0)
        shared = Pair{0, 0};
    __syncthreads();
    const unsigned long long own = blockIdx.x * blockDim.x + threadIdx.x + 1;
    const Pair old = atomicExch(place, Pair{own, ~own});
    const Pair other = atomicExch_block(&shared, Pair{own, ~own});
    if (old.first != ~old.second || (other.first != ~other.second && other.first != 0))
        atomicAdd(torn, 1);
    atomicAdd(sum, old.first);
}

int main() {
    Pair* pair;
    unsigned long long* sum;
    int* torn;
    CHECK(cudaMallocManaged(&pair, sizeof(Pair)));
    CHECK(cudaMallocManaged(&sum, sizeof *sum));
    CHECK(cudaMallocManaged(&torn, sizeof *torn));
    *pair = Pair{0, 0};
    add<<<32, 64>>>(pair);
    CHECK(cudaDeviceSynchronize());
    std::printf("%llu threads, sum %llu\n", pair->second, pair->first);
    *pair = Pair{0, ~0ull};
    *sum = 0;
    *torn = 0;
    exchange<<<32, 64>>>(pair, sum, torn);
    CHECK(cudaDeviceSynchronize());
    std::printf("%d torn, all together %llu\n", *torn, *sum + pair->first);
    CHECK(cudaFree(pair));
    CHECK(cudaFree(sum));
    CHECK(cudaFree(torn));
    return 0;
}
