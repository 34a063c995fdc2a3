// SPDX-License-Identifier: Apache-2.0
// Functions that are inlined at every level of optimisation: those of traversal and of the run-time
// of device programs, whose cost must not depend on the inliner's heuristics. The same source
// compiles for CPUs, for nvptx64 and as CUDA. Functions with C linkage that the compiler calls by
// name have only the attribute, because the compiler drops unused `inline` functions.
#pragma once

#if defined(__CUDA__)
#define SUNSTONE_INLINE __attribute__((always_inline, device)) static inline
#else
#define SUNSTONE_INLINE __attribute__((always_inline)) static inline
#endif
#define SUNSTONE_INLINE_MEMBER __attribute__((always_inline)) inline
