// SPDX-License-Identifier: Apache-2.0
// printf from a kernel: conversions, widths, strings, 64-bit values.
#include <cuda_runtime.h>

#include "check.h"

__global__ void speak(const char* word, double x) {
    printf("thread %d of %d: %s %.3f %5.1f|%-4d|%lld %c%%\n", threadIdx.x, blockDim.x, word, x,
           float(x) * 2.0f, 7, 1ll << 40, 'a' + threadIdx.x);
}

int main() {
    char* word;
    CHECK(cudaMallocManaged(&word, 16));
    std::snprintf(word, 16, "hello");
    speak<<<1, 3>>>(word, 3.14159);
    CHECK(cudaDeviceSynchronize());
    return 0;
}
