// SPDX-License-Identifier: Apache-2.0
// A prefix sum in one pass, as libraries of primitives have it: tiles take numbers from a counter,
// publish sums with flags in one 64-bit word, and look back at the words of earlier tiles while
// those still run; checked against a sequential sum.
#include "device.h"

#include <vector>

constexpr int kThreads = 128, kItems = 9, kTile = kThreads * kItems;
enum : unsigned { kNothing, kSum, kPrefix };

struct State {
    unsigned ticket;
    unsigned padding[31];
};

__device__ unsigned long long word(unsigned flag, int value) {
    return (unsigned long long)flag << 32 | unsigned(value);
}
__device__ int warpScan(int value) {
    const unsigned lane = threadIdx.x & 31;
#pragma unroll
    for (unsigned step = 1; step < 32; step <<= 1) {
        const int other = __shfl_up_sync(0xffffffffu, value, step);
        value += lane >= step ? other : 0;
    }
    return value;
}

// A warp looks at 32 earlier tiles at a time.
__device__ int lookBack(volatile unsigned long long* words, int tile) {
    const int lane = threadIdx.x & 31;
    int sum = 0;
    for (int base = tile - 1;; base -= 32) {
        const int at = base - lane;
        unsigned long long seen = word(kPrefix, 0);
        if (at >= 0)
            do
                seen = words[at];
            while (unsigned(seen >> 32) == kNothing);
        const unsigned done = __ballot_sync(0xffffffffu, unsigned(seen >> 32) == kPrefix);
        const int last = done ? __ffs(done) - 1 : 31;
        int part = lane <= last ? int(unsigned(seen)) : 0;
        for (int step = 16; step; step >>= 1)
            part += __shfl_xor_sync(0xffffffffu, part, step);
        sum += part;
        if (done)
            return sum;
    }
}

__global__ void __launch_bounds__(kThreads)
    scan(const int* __restrict__ in, int* __restrict__ out, int count, State* state,
         unsigned long long* words) {
    __shared__ int items[kTile], sums[kThreads / 32], before;
    __shared__ unsigned tile;
    if (threadIdx.x == 0)
        tile = atomicAdd(&state->ticket, 1);
    __syncthreads();
    const int base = int(tile) * kTile;
    for (int i = threadIdx.x; i < kTile; i += kThreads)
        items[i] = base + i < count ? in[base + i] : 0;
    __syncthreads();
    int mine[kItems], total = 0;
#pragma unroll
    for (int i = 0; i < kItems; ++i)
        total += mine[i] = items[threadIdx.x * kItems + i];
    const int inclusive = warpScan(total);
    const int warp = threadIdx.x / 32;
    if (threadIdx.x % 32 == 31)
        sums[warp] = inclusive;
    __syncthreads();
    int offset = inclusive - total, all = 0;
    for (int i = 0; i < kThreads / 32; ++i) {
        offset += i < warp ? sums[i] : 0;
        all += sums[i];
    }
    if (warp == 0) {
        if (threadIdx.x == 0) {
            __threadfence();
            atomicExch(&words[tile], word(tile == 0 ? kPrefix : kSum, all));
        }
        const int earlier = tile == 0 ? 0 : lookBack(words, int(tile));
        if (threadIdx.x == 0) {
            before = earlier;
            __threadfence();
            atomicExch(&words[tile], word(kPrefix, earlier + all));
        }
    }
    __syncthreads();
    offset += before;
#pragma unroll
    for (int i = 0; i < kItems; ++i)
        items[threadIdx.x * kItems + i] = offset += mine[i];
    __syncthreads();
    for (int i = threadIdx.x; i < kTile; i += kThreads)
        if (base + i < count)
            out[base + i] = items[i];
}

int main() {
    int wrong = 0;
    for (const int count : {1, 31, kTile, kTile + 1, 100000}) {
        std::vector<int> data(count), result(count);
        for (int i = 0; i < count; ++i)
            data[i] = int((unsigned(i) * 2654435761u) >> 24) - 100;
        const int tiles = (count + kTile - 1) / kTile;
        int* memory;
        State* state;
        CUDA(cudaMalloc(&memory, 2 * count * sizeof(int)));
        CUDA(cudaMalloc(&state, sizeof(State) + tiles * sizeof(unsigned long long)));
        CUDA(cudaMemset(state, 0, sizeof(State) + tiles * sizeof(unsigned long long)));
        CUDA(cudaMemcpy(memory, data.data(), count * sizeof(int), cudaMemcpyHostToDevice));
        scan<<<tiles, kThreads>>>(memory, memory + count, count, state,
                                  reinterpret_cast<unsigned long long*>(state + 1));
        CUDA(
            cudaMemcpy(result.data(), memory + count, count * sizeof(int), cudaMemcpyDeviceToHost));
        for (int i = 0, sum = 0; i < count; ++i)
            wrong += result[i] != (sum += data[i]);
        CUDA(cudaFree(memory));
        CUDA(cudaFree(state));
    }
    std::printf("%d wrong\n", wrong);
    return finish(wrong == 0);
}
