// SPDX-License-Identifier: Apache-2.0
// A CUDA kernel to debug. The tests know its line numbers.

static __device__ __noinline__ int doubled(int value) {
    int result = value * 2;
    return result;
}

extern "C" __global__ void accumulate(int* out, int count) {
    __shared__ int tile[4];
    int sum = 100;
    for (int i = 0; i < count; ++i) {
        int term = doubled(i) + 1;
        sum += term;
    }
    tile[threadIdx.x] = sum;
    __syncthreads();
    out[threadIdx.x] = tile[threadIdx.x];
}
