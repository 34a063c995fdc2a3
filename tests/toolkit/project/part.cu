// SPDX-License-Identifier: Apache-2.0
__device__ int offsets[2] = {3, 4};
__device__ int part(int value) {
    return value + offsets[0] + offsets[1];
}
extern "C" __global__ void partKernel(int* to) {
    *to = part(int(threadIdx.x));
}
