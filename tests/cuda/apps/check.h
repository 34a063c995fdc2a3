// SPDX-License-Identifier: Apache-2.0
// Error checks of the small programs: stop at the first CUDA error and print its place.
#pragma once

#include <cstdio>
#include <cstdlib>

#define CHECK(call)                                                                                \
    do {                                                                                           \
        const cudaError_t checked = (call);                                                        \
        if (checked != cudaSuccess) {                                                              \
            std::printf("%s:%d: %s: %s\n", __FILE__, __LINE__, #call, cudaGetErrorName(checked));  \
            std::exit(1);                                                                          \
        }                                                                                          \
    } while (0)
