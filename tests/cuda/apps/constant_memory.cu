// SPDX-License-Identifier: Apache-2.0
// __constant__ and __device__ variables, written and read from the host.
#include <cuda_runtime.h>

#include "check.h"

__constant__ float coefficients[4];
__device__ int counter = 5;
__device__ float table[3] = {1.5f, 2.5f, 3.5f};

__global__ void evaluate(float x, float* out) {
    float r = 0;
    for (int i = 3; i >= 0; --i)
        r = r * x + coefficients[i];
    out[threadIdx.x] = r + table[threadIdx.x];
    atomicAdd(&counter, 2);
}

int main() {
    const float values[4] = {1, 2, 3, 4};
    CHECK(cudaMemcpyToSymbol(coefficients, values, sizeof values));
    const float other = 10;
    CHECK(cudaMemcpyToSymbol(coefficients, &other, sizeof other, 2 * sizeof(float)));
    float* out;
    CHECK(cudaMalloc(&out, 3 * sizeof(float)));
    evaluate<<<1, 3>>>(2.0f, out);
    float result[3], back[4];
    int count = 0;
    CHECK(cudaMemcpy(result, out, sizeof result, cudaMemcpyDeviceToHost));
    CHECK(cudaMemcpyFromSymbol(back, coefficients, sizeof back));
    CHECK(cudaMemcpyFromSymbol(&count, counter, sizeof count));
    size_t size = 0;
    CHECK(cudaGetSymbolSize(&size, coefficients));
    std::printf("%.1f %.1f %.1f, back %.0f %.0f, counter %d, size %zu\n", result[0], result[1],
                result[2], back[0], back[2], count, size);
    const cudaError_t tooMuch = cudaMemcpyToSymbol(coefficients, values, sizeof values, 4);
    std::printf("too much: %s\n", cudaGetErrorName(tooMuch));
    return 0;
}
