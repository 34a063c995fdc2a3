// SPDX-License-Identifier: Apache-2.0
// Built so that the default stream is one per thread: two threads wait for one another in their
// default streams, which would never end in one stream for both.
#include <cuda_runtime.h>

#include "check.h"

#include <thread>
#include <vector>

__device__ int arrived;

// Waits, but not for ever, until as many kernels run at once.
__global__ void meet(int kernels, int* met) {
    atomicAdd(&arrived, 1);
    const long long start = clock64();
    while (*(volatile int*)&arrived < kernels && clock64() - start < 40000000000ll) {
    }
    *met = *(volatile int*)&arrived >= kernels;
}

__global__ void count(int* out, int value) {
    out[threadIdx.x] += value;
}

static void work(int* out, int* met) {
    meet<<<1, 1>>>(3, met);
    for (int i = 0; i < 100; ++i)
        count<<<1, 32>>>(out, i);
    CHECK(cudaGetLastError());
    CHECK(cudaStreamSynchronize(0));
}

int main() {
    int *out[2], *met;
    CHECK(cudaMallocHost(&met, 2 * sizeof(int)));
    for (int*& memory : out) {
        CHECK(cudaMallocHost(&memory, 32 * sizeof(int)));
        for (int i = 0; i < 32; ++i)
            memory[i] = i;
    }
    // Both kernels once before, so that loading them does not wait for one that waits.
    meet<<<1, 1>>>(1, met);
    count<<<1, 32>>>(out[0], 0);
    CHECK(cudaDeviceSynchronize());
    std::vector<std::thread> threads;
    for (int i = 0; i < 2; ++i)
        threads.emplace_back(work, out[i], &met[i]);
    for (std::thread& thread : threads)
        thread.join();
    std::printf("met: %d %d, sums %d %d\n", met[0], met[1], out[0][0], out[1][31]);
    unsigned flags = 1;
    CHECK(cudaStreamGetFlags(0, &flags));
    std::printf("flags of the default stream: %u\n", flags);
    return 0;
}
