// SPDX-License-Identifier: Apache-2.0
// Functions that are part of their callers at every level of optimisation: those of the walks and
// of the run-time of device programs, whose cost must not depend on the inliner's judgement. The
// same lines compile for CPUs, for nvptx64 and as CUDA. Functions with C linkage that the compiler
// calls by name have the attribute alone: `inline` would drop them.
#pragma once

#if defined(__CUDA__)
#define SUNSTONE_INLINE __attribute__((always_inline, device)) static inline
#else
#define SUNSTONE_INLINE __attribute__((always_inline)) static inline
#endif
#define SUNSTONE_INLINE_MEMBER __attribute__((always_inline)) inline
