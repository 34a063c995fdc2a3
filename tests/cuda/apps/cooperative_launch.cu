// SPDX-License-Identifier: Apache-2.0
// A cooperative launch whose blocks wait for one another at a barrier written by the program.
#include <cuda_runtime.h>

#include "check.h"

constexpr int kThreads = 64;

// `count` starts at 0 and only grows, so that the barrier needs no second phase.
__device__ void gridBarrier(unsigned* count, unsigned round) {
    __syncthreads();
    if (threadIdx.x == 0) {
        __threadfence();
        atomicAdd(count, 1u);
        while (*(volatile unsigned*)count < round * gridDim.x) {
        }
        __threadfence();
    }
    __syncthreads();
}

// Rounds of passing values on to the next block's neighbour: wrong at once if a block is late.
__global__ void pass(int* a, int* b, unsigned* count, int n, int rounds) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    for (int round = 1; round <= rounds; ++round) {
        b[i] = ((volatile int*)a)[(i + 37) % n] + 1;
        gridBarrier(count, unsigned(round));
        int* swap = a;
        a = b;
        b = swap;
    }
}

// Blocks that only spin: one thread each, in turn by a ticket.
__global__ void inTurn(unsigned* ticket, unsigned* order) {
    while (atomicAdd(ticket, 0u) != gridDim.x - 1 - blockIdx.x) {
    }
    order[blockIdx.x] = atomicExch(ticket, gridDim.x - blockIdx.x);
}

int main() {
    int device, supported, processors, perProcessor;
    CHECK(cudaGetDevice(&device));
    CHECK(cudaDeviceGetAttribute(&supported, cudaDevAttrCooperativeLaunch, device));
    CHECK(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device));
    CHECK(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&perProcessor, pass, kThreads, 0));
    std::printf("cooperative launches: %d\n", supported);

    int blocks = 8;
    if (processors * perProcessor < blocks)
        blocks = processors * perProcessor;
    const int n = 8 * kThreads, rounds = 50;
    int *a, *b;
    unsigned* count;
    CHECK(cudaMallocManaged(&a, n * sizeof(int)));
    CHECK(cudaMallocManaged(&b, n * sizeof(int)));
    CHECK(cudaMallocManaged(&count, 4));
    for (int i = 0; i < n; ++i)
        a[i] = i;
    *count = 0;
    int length = n, times = rounds;
    void* args[] = {&a, &b, &count, &length, &times};
    CHECK(cudaLaunchCooperativeKernel(pass, dim3(blocks), dim3(kThreads), args, 0, 0));
    CHECK(cudaDeviceSynchronize());
    int wrong = 0;
    for (int i = 0; i < n; ++i)
        wrong += a[i] != (i + rounds * 37) % n + rounds;
    std::printf("%d of %d values wrong after %d rounds, %u arrivals\n", wrong, n, rounds, *count);

    unsigned* order;
    CHECK(cudaMallocManaged(&order, 16 * 4));
    *count = 0;
    void* turn[] = {&count, &order};
    CHECK(cudaLaunchCooperativeKernel(inTurn, dim3(16), dim3(1), turn, 0, 0));
    CHECK(cudaDeviceSynchronize());
    for (int i = 0; i < 16; ++i)
        std::printf("%u ", order[i]);

    const cudaError_t error = cudaLaunchCooperativeKernel(pass, dim3(processors * perProcessor + 1),
                                                          dim3(kThreads), args, 0, 0);
    std::printf("\none block too many: %s\n", cudaGetErrorName(error));
    cudaGetLastError();

    // The same through the extended launch.
    cudaLaunchAttribute attribute = {};
    attribute.id = cudaLaunchAttributeCooperative;
    attribute.val.cooperative = 1;
    cudaLaunchConfig_t config = {};
    config.gridDim = dim3(blocks);
    config.blockDim = dim3(kThreads);
    config.attrs = &attribute;
    config.numAttrs = 1;
    *count = 0;
    CHECK(cudaLaunchKernelEx(&config, pass, a, b, count, n, rounds));
    CHECK(cudaDeviceSynchronize());
    std::printf("extended launch: %u arrivals\n", *count);
    return 0;
}
