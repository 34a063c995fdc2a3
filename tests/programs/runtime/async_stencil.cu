// SPDX-License-Identifier: Apache-2.0
// A filter with a ring of stages in shared memory: asynchronous copies of 16, 8 and 4 bytes in
// inline assembly, with sources that end early, groups and waits, while earlier stages are
// computed.
#include "device.h"

#include <cstdint>
#include <vector>

constexpr int kThreads = 64, kStages = 4, kTaps = 9, kTile = kThreads * 4;

__device__ __forceinline__ unsigned sharedAddress(const void* pointer) {
    return unsigned(__cvta_generic_to_shared(pointer));
}
// Copies 16 bytes, of which `valid` come from memory and the rest are zeros.
__device__ __forceinline__ void copy16(void* to, const void* from, int valid) {
    asm volatile("cp.async.cg.shared.global [%0], [%1], 16, %2;" ::"r"(sharedAddress(to)),
                 "l"(from), "r"(valid)
                 : "memory");
}
template <int kBytes>
__device__ __forceinline__ void copySmall(void* to, const void* from) {
    asm volatile("cp.async.ca.shared.global [%0], [%1], %2;" ::"r"(sharedAddress(to)), "l"(from),
                 "n"(kBytes)
                 : "memory");
}
__device__ __forceinline__ void commit() {
    asm volatile("cp.async.commit_group;" ::: "memory");
}
template <int kLeft>
__device__ __forceinline__ void wait() {
    asm volatile("cp.async.wait_group %0;" ::"n"(kLeft) : "memory");
}

struct Ring {
    float data[kStages][kTile];
};

// The taps' weights come with copies of 4 and 8 bytes.
__global__ void filter(const float* in, const float* weights, float* out, int n) {
    extern __shared__ __align__(16) unsigned char memory[];
    Ring& ring = *reinterpret_cast<Ring*>(memory);
    __shared__ __align__(8) float taps[kTaps + 1];
    const int t = threadIdx.x, tiles = (n + kTile - 1) / kTile;
    const int perBlock = (tiles + gridDim.x - 1) / gridDim.x;
    const int first = blockIdx.x * perBlock, end = min(first + perBlock, tiles);
    if (first >= end)
        return;
    // One more tile before, for the taps that reach back, and one behind.
    const auto load = [&](int tile) {
        if (tile >= first - 1 && tile <= end) {
            const int at = tile * kTile + 4 * t;
            const int valid = at < 0 || at >= n ? 0 : min(16, 4 * (n - at));
            copy16(&ring.data[(tile + kStages) % kStages][4 * t], valid ? in + at : in, valid);
        }
        commit();
    };
    if (t < 3)
        copySmall<8>(&taps[2 * t], weights + 2 * t);
    else if (t < 3 + kTaps - 6)
        copySmall<4>(&taps[6 + t - 3], weights + 6 + t - 3);
    for (int tile = first - 1; tile < first + 2; ++tile)
        load(tile);
    for (int tile = first; tile < end; ++tile) {
        wait<0>();
        __syncthreads();
        load(tile + 2); // where the tile before the last one was
        for (int k = 0; k < 4; ++k) {
            const int x = k * kThreads + t, i = tile * kTile + x;
            float sum = 0;
            for (int d = 0; d < kTaps; ++d) {
                const int at = x + d - kTaps / 2;
                const int stage = tile + (at < 0 ? -1 : at >= kTile ? 1 : 0);
                sum += taps[d] * ring.data[(stage + kStages) % kStages][(at + kTile) % kTile];
            }
            if (i < n)
                out[i] = sum;
        }
    }
    wait<0>();
}

int main() {
    constexpr int n = 10007;
    std::vector<float> in(n), weights(kTaps), seen(n);
    for (int i = 0; i < n; ++i)
        in[i] = float((i * 7919) % 1000) - 500;
    for (int d = 0; d < kTaps; ++d)
        weights[d] = float(1 << d % 5) - 3;
    float *a, *w, *b;
    CUDA(cudaMalloc(&a, n * 4));
    CUDA(cudaMalloc(&w, (kTaps + 1) * 4));
    CUDA(cudaMalloc(&b, n * 4));
    CUDA(cudaMemcpy(a, in.data(), n * 4, cudaMemcpyHostToDevice));
    CUDA(cudaMemcpy(w, weights.data(), kTaps * 4, cudaMemcpyHostToDevice));
    int wrong = 0;
    CUDA(cudaFuncSetAttribute(filter, cudaFuncAttributeMaxDynamicSharedMemorySize,
                              int(sizeof(Ring))));
    for (const int blocks : {1, 3, 16}) {
        CUDA(cudaMemset(b, 0xff, n * 4));
        filter<<<blocks, kThreads, sizeof(Ring)>>>(a, w, b, n);
        CUDA(cudaMemcpy(seen.data(), b, n * 4, cudaMemcpyDeviceToHost));
        for (int i = 0; i < n; ++i) {
            float sum = 0;
            for (int d = 0; d < kTaps; ++d) {
                const int at = i + d - kTaps / 2;
                sum += at >= 0 && at < n ? weights[d] * in[at] : 0;
            }
            wrong += seen[i] != sum;
        }
    }
    std::printf("%d wrong\n", wrong);
    return finish(wrong == 0);
}
