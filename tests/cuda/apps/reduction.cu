// SPDX-License-Identifier: Apache-2.0
// Cooperation of a block's threads: barriers, static and dynamic shared memory, shuffles, votes,
// atomics.
#include <cuda_runtime.h>

#include "check.h"

__global__ void sumShared(const int* in, int* out) {
    extern __shared__ int data[];
    const unsigned t = threadIdx.x;
    data[t] = in[blockIdx.x * blockDim.x + t];
    __syncthreads();
    for (unsigned s = blockDim.x / 2; s > 0; s /= 2) {
        if (t < s)
            data[t] += data[t + s];
        __syncthreads();
    }
    if (t == 0)
        out[blockIdx.x] = data[0];
}

__global__ void sumShuffle(const int* in, int* total, int n) {
    __shared__ int perWarp[32];
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    int v = i < n ? in[i] : 0;
    for (int d = 16; d > 0; d /= 2)
        v += __shfl_down_sync(0xffffffffu, v, d);
    const int lane = threadIdx.x % warpSize, warp = threadIdx.x / warpSize;
    if (lane == 0)
        perWarp[warp] = v;
    const int positives = __syncthreads_count(i < n && in[i] > 0);
    if (warp == 0) {
        v = lane < int(blockDim.x) / warpSize ? perWarp[lane] : 0;
        for (int m = 16; m > 0; m /= 2)
            v += __shfl_xor_sync(0xffffffffu, v, m);
        if (lane == 0) {
            atomicAdd(&total[0], v);
            atomicMax(&total[1], positives);
        }
    }
    const unsigned ballot = __ballot_sync(0xffffffffu, threadIdx.x % 3 == 0);
    if (i == 0)
        total[2] = __popc(ballot);
}

int main() {
    const int blocks = 37, threads = 256, n = blocks * threads;
    int *in, *out, *total;
    CHECK(cudaMallocManaged(&in, n * sizeof(int)));
    CHECK(cudaMallocManaged(&out, blocks * sizeof(int)));
    CHECK(cudaMallocManaged(&total, 3 * sizeof(int)));
    CHECK(cudaMemset(total, 0, 3 * sizeof(int)));
    long long expected = 0;
    for (int i = 0; i < n; ++i) {
        in[i] = i % 101 - 30;
        expected += in[i];
    }
    sumShared<<<blocks, threads, threads * sizeof(int)>>>(in, out);
    sumShuffle<<<blocks, threads>>>(in, total, n);
    CHECK(cudaDeviceSynchronize());
    long long sum = 0;
    for (int b = 0; b < blocks; ++b)
        sum += out[b];
    std::printf("expected %lld, shared %lld, shuffle %d, positives %d, ballot %d\n", expected, sum,
                total[0], total[1], total[2]);
    return sum != expected || total[0] != expected;
}
