// SPDX-License-Identifier: Apache-2.0
// The runtime's errors for mistakes; the last error is kept and cleared.
#include <cuda_runtime.h>

#include "check.h"

#include <cassert>

__global__ void nothing() {}
__global__ void __launch_bounds__(64) bounded() {}
__global__ void fail() {
    __trap();
}

__global__ void claim(int value, int* after) {
    assert(value == 1);
    *after = value;
}

static void say(const char* what, cudaError_t error) {
    const cudaError_t last = cudaGetLastError();
    std::printf("%s: %s, last %s, then %s\n", what, cudaGetErrorName(error), cudaGetErrorName(last),
                cudaGetErrorName(cudaPeekAtLastError()));
}

int main() {
    CHECK(cudaFree(0));
    char* p;
    CHECK(cudaMalloc(&p, 64));
    char host[128] = {};
    say("copy out of range", cudaMemcpy(p, host, 65, cudaMemcpyHostToDevice));
    say("copy to host memory as device", cudaMemcpy(host, host, 4, cudaMemcpyHostToDevice));
    say("null", cudaMemcpy(nullptr, host, 4, cudaMemcpyHostToDevice));
    say("direction", cudaMemcpy(p, host, 4, (cudaMemcpyKind)77));
    CHECK(cudaFree(p));
    say("double free", cudaFree(p));
    nothing<<<1, 2048>>>();
    say("too many threads", cudaPeekAtLastError());
    nothing<<<0, 1>>>();
    say("empty grid", cudaPeekAtLastError());
    bounded<<<1, 65>>>();
    say("launch bounds", cudaPeekAtLastError());
    nothing<<<1, 1, 1 << 20>>>();
    say("shared memory", cudaPeekAtLastError());
    say("not a kernel", cudaLaunchKernel((const void*)host, dim3(1), dim3(1), nullptr, 0, 0));
    say("symbol", cudaMemcpyToSymbol(host[0], host, 1));
    say("device", cudaSetDevice(99));
    cudaStream_t stream;
    CHECK(cudaStreamCreate(&stream));
    CHECK(cudaStreamDestroy(stream));
    say("destroyed stream", cudaStreamSynchronize(stream));
    nothing<<<1, 1>>>();
    say("fine", cudaDeviceSynchronize());
    fail<<<1, 1>>>();
    say("trap", cudaDeviceSynchronize());
    // Failed device code leaves an error until the device is reset.
    say("allocation after it", cudaMalloc(&p, 64));
    say("reset", cudaDeviceReset());
    int* after;
    CHECK(cudaMallocManaged(&after, sizeof(int)));
    *after = 0;
    claim<<<1, 1>>>(1, after);
    say("assertion that holds", cudaDeviceSynchronize());
    std::printf("after it: %d\n", *after);
    claim<<<1, 1>>>(2, after);
    say("assertion that fails", cudaDeviceSynchronize());
    nothing<<<1, 1>>>();
    say("launch after it", cudaPeekAtLastError());
    say("reset", cudaDeviceReset());
    nothing<<<1, 1>>>();
    say("launch after the reset", cudaDeviceSynchronize());
    return 0;
}
