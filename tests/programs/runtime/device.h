// SPDX-License-Identifier: Apache-2.0
// Code that the programs of this folder share: they use the runtime API.
#pragma once

#include <cstdio>
#include <cstdlib>

static inline void check(cudaError_t result, const char* what, int line) {
    if (result == cudaSuccess)
        return;
    std::printf("line %d: %s: %s\n", line, what, cudaGetErrorString(result));
    std::exit(1);
}
#define CUDA(call) check(call, #call, __LINE__)

static inline int finish(bool right) {
    std::printf(right ? "ok\n" : "wrong\n");
    return right ? 0 : 1;
}
