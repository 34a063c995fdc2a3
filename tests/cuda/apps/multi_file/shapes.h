// SPDX-License-Identifier: Apache-2.0
// Shared by the files of the program: device functions, variables and callbacks across files.
#pragma once

#include <cuda_runtime.h>

struct Range {
    float low, high;
};

using Rule = float (*)(float);

extern __device__ int calls;       // counts.cu
extern __constant__ Range limits;  // counts.cu
extern __device__ Rule rules[3];   // rules.cu
__device__ float clampTo(float x); // rules.cu
__device__ Rule chooseRule(int i); // rules.cu
__device__ void count(int how);    // counts.cu

// One instance for all files that use it.
template <int kFactor>
__global__ void scale(float* data, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        data[i] *= kFactor;
}

int totalCalls(); // counts.cu, host
void setLimits(float low, float high);
void scaleTwice(float* data, int n); // rules.cu, host
