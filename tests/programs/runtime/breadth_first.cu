// SPDX-License-Identifier: Apache-2.0
// A graph library's breadth-first search: two queues in __device__ variables, a queue of the block
// in shared memory that spills, level by level until the host reads an empty queue; checked against
// std::queue.
#include "device.h"

#include <queue>
#include <vector>

constexpr int kNodes = 12000, kLocal = 96;

__device__ int queues[2][kNodes];
__device__ int sizes[2];
__device__ int distances[kNodes];
__constant__ const int* offsets;
__constant__ const int* targets;

__global__ void start(int source) {
    for (int i = threadIdx.x; i < kNodes; i += blockDim.x)
        distances[i] = i == source ? 0 : -1;
    if (threadIdx.x == 0) {
        queues[0][0] = source;
        sizes[0] = 1;
        sizes[1] = 0;
    }
}

__global__ void __launch_bounds__(128, 4) expand(int level) {
    __shared__ int local[kLocal], count, base;
    const int from = level & 1, to = from ^ 1;
    if (threadIdx.x == 0)
        count = 0;
    __syncthreads();
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < sizes[from]) {
        const int node = queues[from][i];
        for (int edge = offsets[node]; edge < offsets[node + 1]; ++edge) {
            const int next = targets[edge];
            if (atomicCAS(&distances[next], -1, level + 1) != -1)
                continue;
            const int at = atomicAdd(&count, 1);
            if (at < kLocal)
                local[at] = next;
            else
                queues[to][atomicAdd(&sizes[to], 1)] = next;
        }
    }
    __syncthreads();
    const int kept = min(count, kLocal);
    if (threadIdx.x == 0)
        base = atomicAdd(&sizes[to], kept);
    __syncthreads();
    for (int j = threadIdx.x; j < kept; j += blockDim.x)
        queues[to][base + j] = local[j];
}

int main() {
    std::vector<int> first(kNodes + 1), edges;
    unsigned state = 7;
    for (int node = 0; node < kNodes; ++node) {
        first[node] = int(edges.size());
        const int degree = node % 500 == 3 ? 400 : node % 5;
        for (int i = 0; i < degree; ++i) {
            state = state * 1664525u + 1013904223u;
            edges.push_back((node + (state >> 8) % 900) % kNodes);
        }
    }
    first[kNodes] = int(edges.size());
    int *deviceFirst, *deviceEdges;
    CUDA(cudaMalloc((void**)&deviceFirst, first.size() * sizeof(int)));
    CUDA(cudaMalloc((void**)&deviceEdges, edges.size() * sizeof(int)));
    CUDA(cudaMemcpy(deviceFirst, first.data(), first.size() * sizeof(int), cudaMemcpyDefault));
    CUDA(cudaMemcpy(deviceEdges, edges.data(), edges.size() * sizeof(int), cudaMemcpyDefault));
    CUDA(cudaMemcpyToSymbol(offsets, &deviceFirst, sizeof(deviceFirst)));
    CUDA(cudaMemcpyToSymbol(targets, &deviceEdges, sizeof(deviceEdges)));

    const int source = 3;
    start<<<1, 256>>>(source);
    int level = 0, size = 1;
    for (; size > 0; ++level) {
        expand<<<(size + 127) / 128, 128>>>(level);
        CUDA(cudaMemcpyFromSymbol(&size, sizes, sizeof(int), ((level & 1) ^ 1) * sizeof(int)));
        const int zero = 0;
        CUDA(cudaMemcpyToSymbol(sizes, &zero, sizeof(int), (level & 1) * sizeof(int)));
    }
    std::vector<int> result(kNodes), expected(kNodes, -1);
    CUDA(cudaMemcpyFromSymbol(result.data(), distances, sizeof(int) * kNodes));
    std::queue<int> open;
    open.push(source);
    expected[source] = 0;
    for (; !open.empty(); open.pop())
        for (int e = first[open.front()]; e < first[open.front() + 1]; ++e)
            if (expected[edges[e]] < 0) {
                expected[edges[e]] = expected[open.front()] + 1;
                open.push(edges[e]);
            }
    int wrong = 0;
    for (int i = 0; i < kNodes; ++i)
        wrong += result[i] != expected[i];
    std::printf("%d levels, %d wrong\n", level, wrong);
    CUDA(cudaFree(deviceFirst));
    CUDA(cudaFree(deviceEdges));
    return finish(wrong == 0 && level > 5);
}
