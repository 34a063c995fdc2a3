// SPDX-License-Identifier: Apache-2.0
// CUDA kernels of the program rigid_bodies: transforms of instances, and waves.
#include "rigid_bodies.h"

#include "sampling.h"

static __device__ float part(unsigned number, unsigned stream) {
    return float(hashPcg(number * 16 + stream) >> 8) * 0x1p-24f;
}

// Bodies tumble on arcs between two heights.
extern "C" __global__ void moveBodies(BodyMotion m) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= m.bodies)
        return;
    const float phase = m.time * (0.5f + part(i, 0)) + part(i, 1), along = phase - floorf(phase);
    const float2 around = circlePoint(part(i, 2)), axis = circlePoint(part(i, 3));
    const float r = 19.0f * sqrtf(part(i, 4));
    const float height = 0.5f + (1.0f + 5.0f * part(i, 5)) * 4.0f * along * (1.0f - along);
    // A turn around the axis (axis.x, 0, axis.y).
    const float2 turn = circlePoint(along);
    const float c = turn.x, s = turn.y, rest = 1.0f - c, size = 0.25f + 0.35f * part(i, 6);
    const float rows[3][3] = {{c + rest * axis.x * axis.x, -s * axis.y, rest * axis.x * axis.y},
                              {s * axis.y, c, -s * axis.x},
                              {rest * axis.x * axis.y, s * axis.x, c + rest * axis.y * axis.y}};
    const float at[3] = {r * around.x, height, r * around.y};
    OptixInstance instance = {};
    for (unsigned row = 0; row < 3; ++row) {
        for (unsigned column = 0; column < 3; ++column)
            instance.transform[4 * row + column] = size * rows[row][column];
        instance.transform[4 * row + 3] = at[row];
    }
    instance.instanceId = i;
    instance.sbtOffset = i % kBodyShapes + kBodyShapes * (i / kBodyShapes % 4);
    instance.visibilityMask = 255;
    instance.traversableHandle = m.shapes[i % kBodyShapes];
    m.instances[2 + i] = instance;
}

extern "C" __global__ void moveWater(BodyMotion m) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= m.waterVertices)
        return;
    const float2 p = m.rest[i];
    const float wave = 0.12f * sinf(1.3f * p.x + 2.0f * m.time) +
                       0.08f * sinf(2.1f * p.y - 3.0f * m.time) +
                       0.03f * sinf(5.0f * (p.x + p.y) + 4.0f * m.time);
    m.water[i] = make_float3(p.x, wave - 0.4f, p.y);
}
