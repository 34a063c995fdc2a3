// SPDX-License-Identifier: Apache-2.0
// Several files with relocatable device code: functions, variables and callbacks across files.
#include "shapes.h"

#include "../check.h"

#include <initializer_list>

// Has the name of a function in another file, and is not it.
static __device__ float halve(float x) {
    return x / 4;
}

__global__ void apply(float* data, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        data[i] = chooseRule(i)(data[i]) + rules[2](1000.0f) + halve(8);
}

int main() {
    const int n = 100;
    float* data;
    CHECK(cudaMallocManaged(&data, n * sizeof(float)));
    for (int i = 0; i < n; ++i)
        data[i] = float(i);
    setLimits(10, 50);
    scale<3><<<4, 32>>>(data, n);
    CHECK(cudaGetLastError());
    scaleTwice(data, n);
    apply<<<4, 32>>>(data, n);
    CHECK(cudaDeviceSynchronize());
    for (int i : {0, 1, 2, 3, 97, 98, 99})
        std::printf("%.2f ", data[i]);
    std::printf("\n%d calls\n", totalCalls());
    return 0;
}
