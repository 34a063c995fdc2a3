// SPDX-License-Identifier: Apache-2.0
// saxpy in pieces over several streams, ordered and timed by events.
#include <cuda_runtime.h>

#include "check.h"

__global__ void saxpy(float a, const float* x, float* y, int n) {
    for (int i = blockIdx.x * blockDim.x + threadIdx.x; i < n; i += gridDim.x * blockDim.x)
        y[i] = a * x[i] + y[i];
}

int main() {
    const int streams = 4, piece = 1 << 16, n = streams * piece;
    float *x, *y, *dx, *dy;
    CHECK(cudaMallocHost(&x, n * sizeof(float)));
    CHECK(cudaMallocHost(&y, n * sizeof(float)));
    CHECK(cudaMalloc(&dx, n * sizeof(float)));
    CHECK(cudaMalloc(&dy, n * sizeof(float)));
    for (int i = 0; i < n; ++i) {
        x[i] = float(i % 1000);
        y[i] = 1.0f;
    }
    cudaStream_t stream[streams];
    cudaEvent_t start, done[streams], end;
    CHECK(cudaEventCreate(&start));
    CHECK(cudaEventCreate(&end));
    CHECK(cudaEventRecord(start));
    for (int s = 0; s < streams; ++s) {
        CHECK(cudaStreamCreateWithFlags(&stream[s], cudaStreamNonBlocking));
        CHECK(cudaEventCreateWithFlags(&done[s], cudaEventDisableTiming));
        const size_t at = size_t(s) * piece, bytes = piece * sizeof(float);
        CHECK(cudaMemcpyAsync(dx + at, x + at, bytes, cudaMemcpyHostToDevice, stream[s]));
        CHECK(cudaMemcpyAsync(dy + at, y + at, bytes, cudaMemcpyHostToDevice, stream[s]));
        saxpy<<<16, 128, 0, stream[s]>>>(2.0f, dx + at, dy + at, piece);
        CHECK(cudaGetLastError());
        CHECK(cudaEventRecord(done[s], stream[s]));
    }
    // The first stream collects all of it once the others are done.
    for (int s = 0; s < streams; ++s)
        CHECK(cudaStreamWaitEvent(stream[0], done[s], 0));
    CHECK(cudaMemcpyAsync(y, dy, n * sizeof(float), cudaMemcpyDeviceToHost, stream[0]));
    CHECK(cudaEventRecord(end, stream[0]));
    CHECK(cudaEventSynchronize(end));
    float ms = -1;
    CHECK(cudaEventElapsedTime(&ms, start, end));
    int wrong = 0;
    for (int i = 0; i < n; ++i)
        wrong += y[i] != 2.0f * (i % 1000) + 1.0f;
    std::printf("wrong %d, time %s\n", wrong, ms > 0 && ms < 10000 ? "plausible" : "not plausible");
    for (int s = 0; s < streams; ++s) {
        CHECK(cudaStreamDestroy(stream[s]));
        CHECK(cudaEventDestroy(done[s]));
    }
    CHECK(cudaFreeHost(x));
    CHECK(cudaFreeHost(y));
    return wrong != 0;
}
