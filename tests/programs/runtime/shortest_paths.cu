// SPDX-License-Identifier: Apache-2.0
// All shortest paths of a network in tiles (three phases a round, shared arrays of two dimensions),
// recorded by stream capture and launched as a graph with a host function; checked against three
// loops.
#include "device.h"

#include <algorithm>
#include <vector>

constexpr int kN = 96, kTile = 16;

__device__ void relax(int c[kTile][kTile], const int a[kTile][kTile], const int b[kTile][kTile]) {
    for (int k = 0; k < kTile; ++k) {
        c[threadIdx.y][threadIdx.x] =
            min(c[threadIdx.y][threadIdx.x], a[threadIdx.y][k] + b[k][threadIdx.x]);
        __syncthreads();
    }
}
__device__ int* cell(int* d, int row, int column) {
    return d + (row * kTile + threadIdx.y) * kN + column * kTile + threadIdx.x;
}
__global__ void diagonal(int* d, int round) {
    __shared__ int tile[kTile][kTile];
    tile[threadIdx.y][threadIdx.x] = *cell(d, round, round);
    __syncthreads();
    relax(tile, tile, tile);
    *cell(d, round, round) = tile[threadIdx.y][threadIdx.x];
}
__global__ void cross(int* d, int round) {
    __shared__ int pivot[kTile][kTile], tile[kTile][kTile];
    if (int(blockIdx.x) == round)
        return;
    const bool row = blockIdx.y == 0;
    int* const at = row ? cell(d, round, blockIdx.x) : cell(d, blockIdx.x, round);
    pivot[threadIdx.y][threadIdx.x] = *cell(d, round, round);
    tile[threadIdx.y][threadIdx.x] = *at;
    __syncthreads();
    if (row)
        relax(tile, pivot, tile);
    else
        relax(tile, tile, pivot);
    *at = tile[threadIdx.y][threadIdx.x];
}
__global__ void rest(int* d, int round) {
    __shared__ int left[kTile][kTile], top[kTile][kTile + 1];
    const int row = blockIdx.y, column = blockIdx.x;
    if (row == round || column == round)
        return;
    left[threadIdx.y][threadIdx.x] = *cell(d, row, round);
    top[threadIdx.y][threadIdx.x] = *cell(d, round, column);
    __syncthreads();
    int best = *cell(d, row, column);
#pragma unroll 4
    for (int k = 0; k < kTile; ++k)
        best = min(best, left[threadIdx.y][k] + top[k][threadIdx.x]);
    *cell(d, row, column) = best;
}

int main() {
    std::vector<int> network(kN * kN), result(kN * kN);
    unsigned state = 11;
    for (int i = 0; i < kN * kN; ++i) {
        state = state * 1664525u + 1013904223u;
        network[i] = i / kN == i % kN ? 0 : state >> 28 == 0 ? int(state >> 8 & 1023) : 1 << 20;
    }
    int *d, finished = 0;
    cudaStream_t stream;
    cudaGraph_t graph;
    cudaGraphExec_t executable;
    CUDA(cudaMalloc(&d, network.size() * sizeof(int)));
    CUDA(cudaStreamCreate(&stream));
    CUDA(cudaStreamBeginCapture(stream, cudaStreamCaptureModeGlobal));
    CUDA(cudaMemcpyAsync(d, network.data(), network.size() * sizeof(int), cudaMemcpyHostToDevice,
                         stream));
    const dim3 block(kTile, kTile);
    for (int round = 0; round < kN / kTile; ++round) {
        diagonal<<<1, block, 0, stream>>>(d, round);
        cross<<<dim3(kN / kTile, 2), block, 0, stream>>>(d, round);
        rest<<<dim3(kN / kTile, kN / kTile), block, 0, stream>>>(d, round);
    }
    CUDA(cudaMemcpyAsync(result.data(), d, result.size() * sizeof(int), cudaMemcpyDeviceToHost,
                         stream));
    CUDA(cudaLaunchHostFunc(stream, [](void* n) { ++*static_cast<int*>(n); }, &finished));
    CUDA(cudaStreamEndCapture(stream, &graph));
    CUDA(cudaGraphInstantiate(&executable, graph, 0));
    int wrong = 0;
    for (int launch = 0; launch < 3; ++launch) {
        network[launch * kN + 50] = 1; // read when the graph runs
        CUDA(cudaGraphLaunch(executable, stream));
        CUDA(cudaStreamSynchronize(stream));
        std::vector<int> expected = network;
        for (int k = 0; k < kN; ++k)
            for (int i = 0; i < kN * kN; ++i)
                expected[i] =
                    std::min(expected[i], expected[i / kN * kN + k] + expected[k * kN + i % kN]);
        for (int i = 0; i < kN * kN; ++i)
            wrong += result[i] != expected[i];
    }
    std::printf("%d launches, %d wrong\n", finished, wrong);
    CUDA(cudaGraphExecDestroy(executable));
    CUDA(cudaGraphDestroy(graph));
    CUDA(cudaStreamDestroy(stream));
    CUDA(cudaFree(d));
    return finish(wrong == 0 && finished == 3);
}
