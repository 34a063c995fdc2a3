// SPDX-License-Identifier: Apache-2.0
// CUDA's additions to C++ (__host__, __device__, ...). They are attributes of the compiler in a
// CUDA compilation, otherwise empty.
#ifndef SUNSTONE_HOST_DEFINES_H
#define SUNSTONE_HOST_DEFINES_H
#ifndef __HOST_DEFINES_H__
#define __HOST_DEFINES_H__ // disables a toolkit's header
#endif

#define CUDARTAPI
#define CUDART_CB
#define CUDAAPI
#define CUDA_CB

#if defined(__CUDA__) || defined(__CUDACC__)
#define __location__(a) __attribute__((a))
#define __noinline__ __attribute__((noinline))
#define __launch_bounds__(...) __attribute__((launch_bounds(__VA_ARGS__)))
#define __maxnreg__(n)
#define __inline_hint__
#define __device_builtin__
#if defined(__has_attribute) && __has_attribute(grid_constant)
#define __grid_constant__ __attribute__((grid_constant))
#else
#define __grid_constant__
#endif
#else
#define __location__(a)
#define __launch_bounds__(...)
#define __grid_constant__
#endif

#define __host__ __location__(host)
#define __device__ __location__(device)
#define __global__ __location__(global)
#define __shared__ __location__(shared)
#define __constant__ __location__(constant)
#define __managed__ __location__(managed)

#ifndef __forceinline__
#define __forceinline__ __inline__ __attribute__((always_inline))
#endif
#define __align__(n) __attribute__((aligned(n)))
#define __builtin_align__(n) __attribute__((aligned(n)))
#define __no_return__ __attribute__((noreturn))

#endif
