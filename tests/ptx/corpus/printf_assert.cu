// SPDX-License-Identifier: Apache-2.0
// Variadic calls through a buffer in local memory, and assertions.
#include <cassert>
#include <cstdio>

extern "C" __global__ void report(const float* values, int count) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    assert(i < count);
    if (values[i] < 0.0f)
        printf("value %d is %f, below %s\n", i, values[i], "zero");
}
