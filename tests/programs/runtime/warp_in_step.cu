// SPDX-License-Identifier: Apache-2.0
// Kernels of the time before independent threads: they count on the lanes of a warp to keep step,
// so they exchange values through volatile shared memory, and have no barrier among 32 threads.
#include "device.h"

#include <vector>

// The last steps of a reduction, as it was taught.
__device__ void lastWarp(volatile int* shared, int thread) {
    shared[thread] += shared[thread + 32];
    shared[thread] += shared[thread + 16];
    shared[thread] += shared[thread + 8];
    shared[thread] += shared[thread + 4];
    shared[thread] += shared[thread + 2];
    shared[thread] += shared[thread + 1];
}
__global__ void reduce(const int* in, int* out, int count) {
    __shared__ int shared[256 + 32];
    const int thread = threadIdx.x;
    int sum = 0;
    for (int i = blockIdx.x * 256 + thread; i < count; i += gridDim.x * 256)
        sum += in[i];
    shared[thread] = sum;
    __syncthreads();
    if (thread < 128)
        shared[thread] += shared[thread + 128];
    __syncthreads();
    if (thread < 64)
        shared[thread] += shared[thread + 64];
    __syncthreads();
    if (thread < 32)
        lastWarp(shared, thread);
    if (thread == 0)
        atomicAdd(out, shared[0]);
}

// A prefix sum over a warp in memory; every lane reads before any lane writes.
__global__ void scan(int* data) {
    __shared__ volatile int row[64];
    const int lane = threadIdx.x;
    row[lane] = 0;
    row[32 + lane] = data[blockIdx.x * 32 + lane];
    for (int step = 1; step < 32; step *= 2) {
        const int other = row[32 + lane - step];
        row[32 + lane] = row[32 + lane] + other;
    }
    data[blockIdx.x * 32 + lane] = row[32 + lane];
}

// A queue: all lanes read the counter, then lane 0 moves it on by as many as are active.
__global__ void append(const int* in, int* out, int* counts) {
    __shared__ volatile int end;
    __shared__ volatile unsigned wanted;
    const int lane = threadIdx.x;
    end = 0;
    for (int round = 0; round < 8; ++round) {
        const int value = in[(blockIdx.x * 8 + round) * 32 + lane];
        wanted = 0;
        if (value % 3 == 0)
            atomicOr(const_cast<unsigned*>(&wanted), 1u << lane);
        const unsigned mask = wanted;
        const int begin = end;
        if (value % 3 == 0)
            out[blockIdx.x * 256 + begin + __popc(mask & ((1u << lane) - 1))] = value;
        if (lane == 0)
            end = begin + __popc(mask);
    }
    if (lane == 0)
        counts[blockIdx.x] = end;
}

int main() {
    constexpr int kCount = 1 << 14, kBlocks = kCount / 256;
    std::vector<int> data(kCount);
    int total = 0;
    for (int i = 0; i < kCount; ++i)
        total += data[i] = int((i * 2654435761u) >> 20) % 100;
    int *in, *work, *sums;
    CUDA(cudaMalloc(&in, kCount * sizeof(int)));
    CUDA(cudaMalloc(&work, kCount * sizeof(int)));
    CUDA(cudaMalloc(&sums, kBlocks * sizeof(int)));
    CUDA(cudaMemcpy(in, data.data(), kCount * sizeof(int), cudaMemcpyHostToDevice));

    CUDA(cudaMemset(sums, 0, sizeof(int)));
    reduce<<<8, 256>>>(in, sums, kCount);
    int sum;
    CUDA(cudaMemcpy(&sum, sums, sizeof(int), cudaMemcpyDeviceToHost));
    std::printf("sum %s\n", sum == total ? "right" : "wrong");
    bool right = sum == total;

    CUDA(cudaMemcpy(work, in, kCount * sizeof(int), cudaMemcpyDeviceToDevice));
    scan<<<kCount / 32, 32>>>(work);
    std::vector<int> result(kCount);
    CUDA(cudaMemcpy(result.data(), work, kCount * sizeof(int), cudaMemcpyDeviceToHost));
    int wrong = 0;
    for (int i = 0, before = 0; i < kCount; ++i) {
        before = (i % 32 ? before : 0) + data[i];
        wrong += result[i] != before;
    }
    std::printf("scan: %d wrong\n", wrong);
    right = right && wrong == 0;

    append<<<kBlocks, 32>>>(in, work, sums);
    std::vector<int> counts(kBlocks);
    CUDA(cudaMemcpy(result.data(), work, kCount * sizeof(int), cudaMemcpyDeviceToHost));
    CUDA(cudaMemcpy(counts.data(), sums, kBlocks * sizeof(int), cudaMemcpyDeviceToHost));
    wrong = 0;
    for (int block = 0; block < kBlocks; ++block) {
        int end = 0;
        for (int i = 0; i < 256; ++i)
            if (data[block * 256 + i] % 3 == 0)
                wrong += result[block * 256 + end++] != data[block * 256 + i];
        wrong += counts[block] != end;
    }
    std::printf("queue: %d wrong\n", wrong);
    return finish(right && wrong == 0);
}
