// SPDX-License-Identifier: Apache-2.0
// Code that the programs of this folder share: they use only the driver API.
#pragma once

#include <cuda.h>

#include <cstdio>
#include <cstdlib>

inline void check(CUresult result, const char* what, int line) {
    if (result == CUDA_SUCCESS)
        return;
    const char* name = "?";
    cuGetErrorName(result, &name);
    std::printf("line %d: %s: %s\n", line, what, name);
    std::exit(1);
}
#define CU(call) check(call, #call, __LINE__)

inline int finish(bool right) {
    std::printf(right ? "ok\n" : "wrong\n");
    return right ? 0 : 1;
}
