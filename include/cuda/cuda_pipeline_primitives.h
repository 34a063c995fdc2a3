// SPDX-License-Identifier: Apache-2.0
// Copies of a thread from global to shared memory, in stages, for clang's CUDA mode. A copy
// completes at once, so every stage is complete. Source: CUDA C++ Programming Guide, "Pipeline
// Primitives Interface".
#ifndef SUNSTONE_CUDA_PIPELINE_PRIMITIVES_H
#define SUNSTONE_CUDA_PIPELINE_PRIMITIVES_H

#include "cuda_runtime.h"

#ifdef SUNSTONE_CUDA_COMPILATION
// Copies `size` bytes (4, 8 or 16), of which the last `zeros` become zero.
static __inline__ __attribute__((device)) void
__pipeline_memcpy_async(void* to, const void* from, size_t size, size_t zeros = 0) {
    unsigned int words[4] = {};
    for (size_t i = 0; i < size / 4; ++i)
        if (i * 4 + zeros < size)
            words[i] = ((const unsigned int*)from)[i];
    if (zeros % 4)
        words[(size - zeros) / 4] &= (1u << (4 - zeros % 4) * 8) - 1;
    for (size_t i = 0; i < size / 4; ++i)
        ((unsigned int*)to)[i] = words[i];
}
static __inline__ __attribute__((device)) void __pipeline_commit() {}
static __inline__ __attribute__((device)) void __pipeline_wait_prior(size_t) {
    asm volatile("" ::: "memory");
}
#endif
#endif
