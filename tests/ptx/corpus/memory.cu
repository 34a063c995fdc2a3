// SPDX-License-Identifier: Apache-2.0
// State spaces, vectors, atomics, shuffles, votes, barriers.
#include <cuda_fp16.h>

__constant__ float coefficients[8] = {1.0f, 2.0f, 3.0f};
__constant__ int4 quad = {1, 2, 3, 4};
__device__ unsigned counter = 7;
__device__ unsigned* counterAddress = &counter;
__device__ const char* text = "text";
__device__ double matrix[2][3] = {{1, 2, 3}, {4, 5}};
__device__ __managed__ int managedValue = 3;
extern __shared__ float dynamicShared[];

struct alignas(16) Parameters {
    float4 color;
    const float* data;
    unsigned char flags[5];
};

extern "C" __global__ void spaces(Parameters p, float4* __restrict__ out, const float4* __restrict__ in) {
    __shared__ float tile[32][33];
    __shared__ double sum;
    const int i = threadIdx.x;
    tile[i][0] = in[i].x * coefficients[i & 7] + p.data[p.flags[i % 5]];
    dynamicShared[i] = __ldg(&in[i].y) + quad.z;
    __syncthreads();
    float v = tile[i ^ 1][0] + dynamicShared[31 - i];
    v += __shfl_sync(0xffffffff, v, 3) + __shfl_up_sync(0xffffffff, v, 1) + __shfl_xor_sync(0xffffffff, v, 16);
    const unsigned ballot = __ballot_sync(0xffffffff, v > 0);
    if (__any_sync(0xffffffff, v < 0) || __all_sync(ballot, i & 1))
        atomicAdd(&counter, ballot);
    atomicAdd(&out[0].x, v);
    atomicCAS(&counter, 1u, 2u);
    atomicExch((int*)counterAddress, i);
    atomicMax((int*)&counter, i);
    atomicAdd(&sum, (double)v);
    atomicInc(&counter, 3u);
    atomicOr(&counter, __activemask() | __match_any_sync(0xffffffff, i));
    __threadfence();
    __threadfence_block();
    __syncwarp();
    const int any = __syncthreads_or(i > 5) + __syncthreads_count(i > 6);
    out[i] = make_float4(v, (float)sum, text[i & 3] + matrix[i & 1][i % 3], any + managedValue);
    volatile float* direct = &out[i].x;
    *direct = *direct + clock() + clock64();
    __stcs(&out[i + 1].x, __ldcg(&in[2].z));
}

extern "C" __global__ void halves(__half* h, __half2* h2, float* f) {
    h[0] = __hadd(h[1], __hmul(h[2], __float2half(f[0])));
    h[3] = __hfma(h[0], h[1], h[2]);
    h2[0] = __hadd2(h2[1], __hfma2(h2[2], h2[3], h2[4]));
    f[1] = __half2float(h[0]) + __low2float(h2[0]);
    f[2] = __hlt(h[0], h[1]) ? 1.0f : 2.0f;
    h[4] = __int2half_rn((int)f[3]);
    h[5] = hsin(h[4]);
}
