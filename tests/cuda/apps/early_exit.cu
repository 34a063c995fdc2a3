// SPDX-License-Identifier: Apache-2.0
// main returns while kernels are queued, and the destructor of a static object still calls the
// runtime.
#include "check.h"

namespace {

__global__ void work(unsigned* sum, int rounds) {
    unsigned x = threadIdx.x;
    for (int i = 0; i < rounds; ++i)
        x = x * 1664525u + 1013904223u;
    atomicAdd(sum, x);
}

struct Memory {
    unsigned* sum = nullptr;
    ~Memory() {
        const cudaError_t result = cudaFree(sum);
        // The driver may be unloaded by now.
        std::printf("%s\n", result == cudaSuccess || result == cudaErrorCudartUnloading ? "freed"
                                                                                         : "not freed");
    }
};
Memory memory;

} // namespace

int main() {
    CHECK(cudaMalloc(&memory.sum, sizeof *memory.sum));
    cudaStream_t streams[2];
    for (cudaStream_t& stream : streams)
        CHECK(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking));
    for (int i = 0; i < 8; ++i) {
        work<<<64, 256, 0, streams[i % 2]>>>(memory.sum, 4000);
        CHECK(cudaGetLastError());
    }
    std::printf("leaving\n");
    return 0;
}
