// SPDX-License-Identifier: Apache-2.0
// main returns while an endless kernel runs and another one is queued after it. The process ends
// all the same; calls in destructors that still wait for the device return the error that the
// device is gone, or free their memory if the driver has ended the kernel.
#include "check.h"

namespace {

__global__ void endless(volatile int* word) {
    while (*word == 0) {
    }
}
// Without reads that let other threads run.
// Reads nothing.
__global__ void spin(int* word) {
    unsigned x = 1;
    do
        x = x * 1664525u + 1013904223u;
    while ((x | 1) != 0);
    *word = int(x);
}

struct Memory {
    int* word = nullptr;
    ~Memory() { cudaFree(word); }
};
Memory memory;

} // namespace

int main() {
    CHECK(cudaMalloc(&memory.word, sizeof *memory.word));
    CHECK(cudaMemset(memory.word, 0, sizeof *memory.word));
    cudaStream_t streams[2];
    for (cudaStream_t& stream : streams)
        CHECK(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking));
    endless<<<2, 64, 0, streams[0]>>>(memory.word);
    CHECK(cudaGetLastError());
    spin<<<1, 32, 0, streams[1]>>>(memory.word);
    CHECK(cudaGetLastError());
    spin<<<1, 1, 0, streams[0]>>>(memory.word);
    CHECK(cudaGetLastError());
    std::printf("%s\n", cudaGetErrorName(cudaStreamQuery(streams[0])));
    return 0;
}
