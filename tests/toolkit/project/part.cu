// SPDX-License-Identifier: Apache-2.0
static __device__ int offset = 3;
__device__ int part(int value) {
    return value + offset;
}
extern "C" __global__ void partKernel(int* to) {
    *to = part(int(threadIdx.x));
}
