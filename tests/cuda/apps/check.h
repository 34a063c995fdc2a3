// SPDX-License-Identifier: Apache-2.0
// What the little programs share: stop at the first CUDA error, say where.
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
