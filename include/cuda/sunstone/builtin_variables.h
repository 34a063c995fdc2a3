// SPDX-License-Identifier: Apache-2.0
// threadIdx, blockIdx, blockDim, gridDim, warpSize: special registers that read like variables.
#ifndef SUNSTONE_BUILTIN_VARIABLES_H
#define SUNSTONE_BUILTIN_VARIABLES_H

#include "../vector_types.h"

struct SunstoneBuiltin_threadIdx {
    __declspec(property(get = get_x)) unsigned int x;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_x() {
        return __nvvm_read_ptx_sreg_tid_x();
    }
    __declspec(property(get = get_y)) unsigned int y;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_y() {
        return __nvvm_read_ptx_sreg_tid_y();
    }
    __declspec(property(get = get_z)) unsigned int z;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_z() {
        return __nvvm_read_ptx_sreg_tid_z();
    }
    __device__ operator uint3() const {
        uint3 v = {get_x(), get_y(), get_z()};
        return v;
    }
    __device__ operator dim3() const { return dim3(get_x(), get_y(), get_z()); }
};
extern const __device__ __attribute__((weak)) SunstoneBuiltin_threadIdx threadIdx;

struct SunstoneBuiltin_blockIdx {
    __declspec(property(get = get_x)) unsigned int x;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_x() {
        return __nvvm_read_ptx_sreg_ctaid_x();
    }
    __declspec(property(get = get_y)) unsigned int y;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_y() {
        return __nvvm_read_ptx_sreg_ctaid_y();
    }
    __declspec(property(get = get_z)) unsigned int z;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_z() {
        return __nvvm_read_ptx_sreg_ctaid_z();
    }
    __device__ operator uint3() const {
        uint3 v = {get_x(), get_y(), get_z()};
        return v;
    }
    __device__ operator dim3() const { return dim3(get_x(), get_y(), get_z()); }
};
extern const __device__ __attribute__((weak)) SunstoneBuiltin_blockIdx blockIdx;

struct SunstoneBuiltin_blockDim {
    __declspec(property(get = get_x)) unsigned int x;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_x() {
        return __nvvm_read_ptx_sreg_ntid_x();
    }
    __declspec(property(get = get_y)) unsigned int y;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_y() {
        return __nvvm_read_ptx_sreg_ntid_y();
    }
    __declspec(property(get = get_z)) unsigned int z;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_z() {
        return __nvvm_read_ptx_sreg_ntid_z();
    }
    __device__ operator uint3() const {
        uint3 v = {get_x(), get_y(), get_z()};
        return v;
    }
    __device__ operator dim3() const { return dim3(get_x(), get_y(), get_z()); }
};
extern const __device__ __attribute__((weak)) SunstoneBuiltin_blockDim blockDim;

struct SunstoneBuiltin_gridDim {
    __declspec(property(get = get_x)) unsigned int x;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_x() {
        return __nvvm_read_ptx_sreg_nctaid_x();
    }
    __declspec(property(get = get_y)) unsigned int y;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_y() {
        return __nvvm_read_ptx_sreg_nctaid_y();
    }
    __declspec(property(get = get_z)) unsigned int z;
    static __inline__ __attribute__((always_inline)) __device__ unsigned int get_z() {
        return __nvvm_read_ptx_sreg_nctaid_z();
    }
    __device__ operator uint3() const {
        uint3 v = {get_x(), get_y(), get_z()};
        return v;
    }
    __device__ operator dim3() const { return dim3(get_x(), get_y(), get_z()); }
};
extern const __device__ __attribute__((weak)) SunstoneBuiltin_gridDim gridDim;

__attribute__((device)) const int warpSize = 32;

#endif
