// SPDX-License-Identifier: Apache-2.0
// A failing call of the CUDA driver API ends the benchmark.
#pragma once

#include <cuda.h>

#include <cstdio>
#include <cstdlib>

inline void check(CUresult result, const char* what) {
    if (result == CUDA_SUCCESS)
        return;
    const char* name = "?";
    cuGetErrorName(result, &name);
    std::fprintf(stderr, "%s: %s\n", what, name);
    std::exit(1);
}
#define CHECK(call) check(call, #call)
