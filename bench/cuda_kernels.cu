// SPDX-License-Identifier: Apache-2.0
// The kernels of bench_cuda.
#include "cuda_kernels.h"

__device__ void pull(Force& force, const float4& own, const float4& other) {
    const float dx = other.x - own.x, dy = other.y - own.y, dz = other.z - own.z;
    const float square = dx * dx + dy * dy + dz * dz + kSoftening;
    const float scale = other.w / (square * sqrtf(square));
    force.x += dx * scale;
    force.y += dy * scale;
    force.z += dz * scale;
}

// Every thread reads all bodies, without a barrier.
extern "C" __global__ void nBodyPlain(const float4* bodies, Force* forces, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= n)
        return;
    const float4 own = bodies[i];
    Force force = {0, 0, 0};
    for (int j = 0; j < n; ++j)
        pull(force, own, bodies[j]);
    forces[i] = force;
}

// The block reads bodies tile by tile into shared memory, with two barriers per tile.
extern "C" __global__ void nBodyTiled(const float4* bodies, Force* forces, int n) {
    __shared__ float4 tile[kTile];
    const int i = blockIdx.x * kTile + threadIdx.x;
    const float4 own = bodies[i];
    Force force = {0, 0, 0};
    for (int first = 0; first < n; first += kTile) {
        tile[threadIdx.x] = bodies[first + threadIdx.x];
        __syncthreads();
        for (int j = 0; j < kTile; ++j)
            pull(force, own, tile[j]);
        __syncthreads();
    }
    forces[i] = force;
}

__constant__ float weights[2 * kRadius + 1];

// Rows of a picture, clamped at its edges.
extern "C" __global__ void convolve(const float* in, float* out, int width, int height) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x, y = blockIdx.y * blockDim.y + threadIdx.y;
    if (x >= width || y >= height)
        return;
    float sum = 0;
    for (int i = -kRadius; i <= kRadius; ++i) {
        const int at = x + i < 0 ? 0 : x + i >= width ? width - 1 : x + i;
        sum += weights[i + kRadius] * in[y * width + at];
    }
    out[y * width + x] = sum;
}

// Computes one value per block: each thread sums over memory, then a tree in shared memory sums
// over threads.
extern "C" __global__ void reduceShared(const float* in, float* out, int n) {
    __shared__ float sums[kTile];
    float sum = 0;
    for (int i = blockIdx.x * kTile + threadIdx.x; i < n; i += gridDim.x * kTile)
        sum += in[i];
    sums[threadIdx.x] = sum;
    __syncthreads();
    for (unsigned s = kTile / 2; s > 0; s /= 2) {
        if (threadIdx.x < s)
            sums[threadIdx.x] += sums[threadIdx.x + s];
        __syncthreads();
    }
    if (threadIdx.x == 0)
        out[blockIdx.x] = sums[0];
}

// As reduceShared, with shuffles in place of most of the tree.
extern "C" __global__ void reduceShuffle(const float* in, float* out, int n) {
    __shared__ float sums[kTile / 32];
    float sum = 0;
    for (int i = blockIdx.x * kTile + threadIdx.x; i < n; i += gridDim.x * kTile)
        sum += in[i];
    for (int d = 16; d > 0; d /= 2)
        sum += __shfl_down_sync(0xffffffffu, sum, d);
    if (threadIdx.x % 32 == 0)
        sums[threadIdx.x / 32] = sum;
    __syncthreads();
    if (threadIdx.x == 0) {
        for (int w = 1; w < kTile / 32; ++w)
            sum += sums[w];
        out[blockIdx.x] = sum;
    }
}
