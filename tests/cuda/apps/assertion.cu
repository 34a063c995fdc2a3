// SPDX-License-Identifier: Apache-2.0
// A failed device assertion ends its launch; the next call that waits returns the error.
#include <cuda_runtime.h>

#include <cassert>

#include "check.h"

__global__ void check(const int* values) {
    assert(values[threadIdx.x] >= 0);
}

int main() {
    int* values;
    CHECK(cudaMallocManaged(&values, 32 * sizeof(int)));
    for (int i = 0; i < 32; ++i)
        values[i] = i;
    check<<<1, 32>>>(values);
    std::printf("%s\n", cudaGetErrorName(cudaDeviceSynchronize()));
    values[5] = -1;
    check<<<1, 32>>>(values);
    std::printf("%s\n", cudaGetErrorName(cudaDeviceSynchronize()));
    return 0;
}
