// SPDX-License-Identifier: Apache-2.0
// CUDA kernels of the program radiosity: the light of lamps, and a bounce.
#include "radiosity.h"

extern "C" __global__ void emit(RadiosityStep step) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= step.count)
        return;
    const float3 e = step.patches[i].emission;
    step.before[i] = make_float4(e.x, e.y, e.z, 1.0f);
}

extern "C" __global__ void gather(RadiosityStep step) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= step.count)
        return;
    float3 sum = vec(0.0f);
    for (unsigned k = 0; k < step.count; ++k) {
        const float4 light = step.before[k];
        const float factor = step.factors[static_cast<size_t>(k) * step.count + i] *
                             step.patches[k].area / step.patches[i].area;
        sum += vec(light.x, light.y, light.z) * factor;
    }
    const float3 all = step.patches[i].emission + step.patches[i].albedo * sum;
    step.after[i] = make_float4(all.x, all.y, all.z, 1.0f);
}
