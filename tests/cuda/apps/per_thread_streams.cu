// SPDX-License-Identifier: Apache-2.0
// Built so that the default stream is one per thread: two threads wait for one another in their default
// streams, which would never end in one stream for both.
#include <cuda_runtime.h>

#include "check.h"

#include <atomic>
#include <thread>
#include <vector>

__global__ void count(int* out, int value) {
    out[threadIdx.x] += value;
}

static std::atomic<int> arrived(0);

static void CUDART_CB meet(void* user) {
    ++arrived;
    for (long spins = 0; arrived < 2; ++spins) {
        if (spins > 200000000) {
            *static_cast<bool*>(user) = false;
            return;
        }
        std::this_thread::yield();
    }
}

static void work(int* out, bool* met) {
    *met = true;
    CHECK(cudaLaunchHostFunc(0, meet, met));
    for (int i = 0; i < 100; ++i)
        count<<<1, 32>>>(out, i);
    CHECK(cudaGetLastError());
    CHECK(cudaStreamSynchronize(0));
}

int main() {
    int* out[2];
    bool met[2] = {};
    for (int*& memory : out) {
        CHECK(cudaMallocHost(&memory, 32 * sizeof(int)));
        for (int i = 0; i < 32; ++i)
            memory[i] = i;
    }
    std::vector<std::thread> threads;
    for (int i = 0; i < 2; ++i)
        threads.emplace_back(work, out[i], &met[i]);
    for (std::thread& thread : threads)
        thread.join();
    std::printf("met: %d %d, sums %d %d\n", met[0], met[1], out[0][0], out[1][31]);
    unsigned flags = 1;
    CHECK(cudaStreamGetFlags(0, &flags));
    std::printf("flags of the default stream: %u\n", flags);
    return 0;
}
