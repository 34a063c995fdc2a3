// SPDX-License-Identifier: Apache-2.0
// The space of an address: __isGlobal, __isShared, __isLocal and __isConstant of variables of each
// kind, in a kernel whose threads meet and in one whose threads do not.
#include "check.h"

namespace {

__device__ int deviceWord;
__constant__ int constantWord;
extern __shared__ int dynamicWords[];

constexpr int kKinds = 6;

__device__ unsigned spacesOf(const void* address) {
    return __isGlobal(address) | __isShared(address) << 1 | __isLocal(address) << 2 |
           __isConstant(address) << 3;
}

// By a function that is not inlined: the address is that of its caller's variable.
__device__ __attribute__((noinline)) unsigned spacesOfCaller(const int* address) {
    return spacesOf(address) | unsigned(*address) << 8;
}

template <bool kMeet>
__global__ void ask(unsigned* out) {
    __shared__ int sharedWords[32];
    int localWords[4] = {int(threadIdx.x), 1, 2, 3};
    sharedWords[threadIdx.x % 32] = 0;
    if (kMeet)
        __syncthreads();
    unsigned* own = out + kKinds * threadIdx.x;
    own[0] = spacesOf(&deviceWord);
    own[1] = spacesOf(out);
    own[2] = spacesOf(&constantWord);
    own[3] = spacesOf(sharedWords + threadIdx.x % 32);
    own[4] = spacesOf(dynamicWords + threadIdx.x);
    own[5] = spacesOfCaller(localWords + threadIdx.x % 4) & 255u;
}

// Without local memory: may run for a warp at a time.
__global__ void askShared(unsigned* out) {
    __shared__ int words[64];
    words[threadIdx.x] = int(threadIdx.x);
    __syncthreads();
    const int* address = threadIdx.x % 2 ? words + 63 - threadIdx.x : &deviceWord;
    atomicAdd(out + __isShared(address) * 2 + __isConstant(address), 1u);
}

void report(const char* name, const unsigned* device) {
    constexpr int kThreads = 64;
    unsigned host[kKinds * kThreads];
    CHECK(cudaMemcpy(host, device, sizeof host, cudaMemcpyDeviceToHost));
    const char* const kNames[kKinds] = {"device variable", "allocation",     "constant variable",
                                        "shared variable", "dynamic shared", "local variable"};
    for (int kind = 0; kind < kKinds; ++kind) {
        bool same = true;
        for (int i = 0; i < kThreads; ++i)
            same = same && host[kKinds * i + kind] == host[kind];
        const unsigned spaces = host[kind];
        std::printf("%s, %s:%s%s%s%s%s\n", name, kNames[kind], spaces & 1 ? " global" : "",
                    spaces & 2 ? " shared" : "", spaces & 4 ? " local" : "",
                    spaces & 8 ? " constant" : "", same ? "" : " (not in all threads)");
    }
}

} // namespace

int main() {
    unsigned* out = nullptr;
    CHECK(cudaMalloc(&out, kKinds * 64 * sizeof(unsigned)));
    ask<false><<<1, 64, 64 * sizeof(int)>>>(out);
    report("alone", out);
    ask<true><<<1, 64, 64 * sizeof(int)>>>(out);
    report("together", out);
    CHECK(cudaMemset(out, 0, 4 * sizeof(unsigned)));
    askShared<<<1, 64>>>(out);
    unsigned counts[4];
    CHECK(cudaMemcpy(counts, out, sizeof counts, cudaMemcpyDeviceToHost));
    std::printf("neither %u, constant %u, shared %u, both %u\n", counts[0], counts[1], counts[2],
                counts[3]);
    return 0;
}
