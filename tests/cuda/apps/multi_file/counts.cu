// SPDX-License-Identifier: Apache-2.0
// The variables, and the host functions that reach them.
#include "shapes.h"

#include "../check.h"

__device__ int calls = 100;
__constant__ Range limits;

__device__ void count(int how) {
    atomicAdd(&calls, how);
}

int totalCalls() {
    int result;
    CHECK(cudaMemcpyFromSymbol(&result, calls, sizeof result));
    return result;
}

void setLimits(float low, float high) {
    const Range range = {low, high};
    CHECK(cudaMemcpyToSymbol(limits, &range, sizeof range));
}
