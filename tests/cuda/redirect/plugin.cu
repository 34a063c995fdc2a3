// SPDX-License-Identifier: Apache-2.0
// A library with kernels and a static runtime of its own. NAME is its function.
#include <cuda_runtime.h>

__global__ void addUp(int* to, int start) {
    atomicAdd(to, start + int(threadIdx.x));
}

extern "C" __attribute__((visibility("default"))) int NAME(int start) {
    int *memory = nullptr, sum = 0;
    if (cudaMalloc(reinterpret_cast<void**>(&memory), sizeof sum) != cudaSuccess ||
        cudaMemset(memory, 0, sizeof sum) != cudaSuccess)
        return -1;
    addUp<<<1, 10>>>(memory, start);
    if (cudaMemcpy(&sum, memory, sizeof sum, cudaMemcpyDeviceToHost) != cudaSuccess)
        return -2;
    cudaFree(memory);
    return sum;
}
