// SPDX-License-Identifier: Apache-2.0
// Histograms by atomics: straight into global memory, and through one per block in shared memory.
// Then other atomics, of all widths.
#include <cuda_runtime.h>

#include "check.h"

#include <vector>

constexpr int kBins = 64;

__global__ void globalHistogram(const unsigned char* data, int n, unsigned* bins) {
    for (int i = blockIdx.x * blockDim.x + threadIdx.x; i < n; i += gridDim.x * blockDim.x)
        atomicAdd(&bins[data[i] % kBins], 1u);
}

__global__ void sharedHistogram(const unsigned char* data, int n, unsigned* bins) {
    __shared__ unsigned local[kBins];
    for (int b = threadIdx.x; b < kBins; b += blockDim.x)
        local[b] = 0;
    __syncthreads();
    for (int i = blockIdx.x * blockDim.x + threadIdx.x; i < n; i += gridDim.x * blockDim.x)
        atomicAdd(&local[data[i] % kBins], 1u);
    __syncthreads();
    for (int b = threadIdx.x; b < kBins; b += blockDim.x)
        atomicAdd(&bins[b], local[b]);
}

struct Totals {
    unsigned long long sum;
    int least, most;
    unsigned ored, anded, xored, wrapped;
    float floats;
    double doubles;
    unsigned long long largest;
};

__global__ void others(const unsigned char* data, int n, Totals* t) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= n)
        return;
    const int value = int(data[i]) - 100;
    atomicAdd(&t->sum, static_cast<unsigned long long>(data[i]));
    atomicMin(&t->least, value);
    atomicMax(&t->most, value);
    atomicOr(&t->ored, 1u << (data[i] % 20));
    atomicAnd(&t->anded, ~(1u << (data[i] % 20)));
    atomicXor(&t->xored, unsigned(i) * 2654435761u);
    atomicInc(&t->wrapped, 999u);
    atomicAdd(&t->floats, 0.5f);
    atomicAdd(&t->doubles, 0.25);
    // Compare and swap, as in atomics written by programs.
    unsigned long long seen = t->largest;
    const unsigned long long mine = static_cast<unsigned long long>(data[i]) << 40 | unsigned(i);
    while (seen < mine) {
        const unsigned long long before = atomicCAS(&t->largest, seen, mine);
        if (before == seen)
            break;
        seen = before;
    }
}

int main() {
    const int n = 100003;
    std::vector<unsigned char> host(n);
    unsigned expected[kBins] = {};
    for (int i = 0; i < n; ++i) {
        host[i] = static_cast<unsigned char>((i * 37 + i / 11) % 251);
        ++expected[host[i] % kBins];
    }
    unsigned char* data;
    unsigned* bins;
    CHECK(cudaMalloc(&data, n));
    CHECK(cudaMallocManaged(&bins, 2 * kBins * sizeof(unsigned)));
    CHECK(cudaMemcpy(data, host.data(), n, cudaMemcpyHostToDevice));
    CHECK(cudaMemset(bins, 0, 2 * kBins * sizeof(unsigned)));
    globalHistogram<<<20, 128>>>(data, n, bins);
    sharedHistogram<<<20, 128>>>(data, n, bins + kBins);
    CHECK(cudaDeviceSynchronize());
    int wrong[2] = {};
    for (int b = 0; b < kBins; ++b)
        for (int way = 0; way < 2; ++way)
            wrong[way] += bins[way * kBins + b] != expected[b];
    std::printf("wrong bins: global %d, shared %d; bin 7 holds %u\n", wrong[0], wrong[1], bins[7]);

    Totals* t;
    CHECK(cudaMallocManaged(&t, sizeof *t));
    *t = {};
    t->anded = ~0u;
    others<<<(n + 255) / 256, 256>>>(data, n, t);
    CHECK(cudaDeviceSynchronize());
    std::printf("sum %llu, least %d, most %d, or %x, and %x, xor %x, wrapped %u\n", t->sum,
                t->least, t->most, t->ored, t->anded, t->xored, t->wrapped);
    std::printf("float %.1f, double %.2f, largest %llx\n", t->floats, t->doubles, t->largest);
    return 0;
}
