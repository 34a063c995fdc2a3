// SPDX-License-Identifier: Apache-2.0
// Library functions other than mathematics for device code: printf, malloc, assert, memcpy and
// memset.
#ifndef SUNSTONE_LIBRARY_H
#define SUNSTONE_LIBRARY_H

#include "intrinsics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern "C" {
// The compiler turns printf into vprintf with the arguments packed in memory; vprintf, malloc,
// free and __assertfail come from the driver.
__device__ int vprintf(const char* format, const char* arguments);
__device__ int printf(const char* format, ...);
__device__ void* malloc(size_t size) __attribute__((malloc));
__device__ void free(void* p) __attribute__((nothrow));
__device__ void __assertfail(const char* text, const char* file, unsigned int line,
                             const char* function, size_t charSize) __attribute__((noreturn));
// Called by <assert.h>.
static __inline__ __device__ __attribute__((noreturn)) void
__assert_fail(const char* text, const char* file, unsigned int line, const char* function) {
    __assertfail(text, file, line, function, sizeof(char));
}
// The placeholder for pure virtual functions in tables of abstract classes.
#ifdef __cplusplus
__inline__ __device__ __attribute__((weak, noreturn)) void __cxa_pure_virtual() {
    __builtin_trap();
}
__inline__ __device__ __attribute__((weak, noreturn)) void __cxa_deleted_virtual() {
    __builtin_trap();
}
#endif
static __inline__ __attribute__((always_inline, device)) void* memcpy(void* to, const void* from,
                                                                      size_t size) {
    return __builtin_memcpy(to, from, size);
}
static __inline__ __attribute__((always_inline, device)) void* memset(void* to, int value,
                                                                      size_t size) {
    return __builtin_memset(to, value, size);
}
static __inline__ __device__ void* memmove(void* to, const void* from, size_t size) {
    char* t = (char*)to;
    const char* f = (const char*)from;
    if (t < f)
        for (size_t i = 0; i < size; ++i)
            t[i] = f[i];
    else
        for (size_t i = size; i-- > 0;)
            t[i] = f[i];
    return to;
}
} // extern "C"

#endif
