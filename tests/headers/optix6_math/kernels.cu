// SPDX-License-Identifier: Apache-2.0
// The calls as device code: one for each thread.
#include "calls.h"
#include "members.h"

extern "C" __global__ void callAll(int count, const int* cases, const math::Number* in,
                                   math::Number* out) {
    const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
    if (i < count)
        math::call(cases[i], in + i * math::kMostNumbers, out + i * math::kMostNumbers);
}

extern "C" __global__ void callMembers(const float* in, float* out) {
    math::members(in, out);
}
