// SPDX-License-Identifier: Apache-2.0
// CUDA kernels of the program cloth: vertices in waves, and their normals.
#include "cloth.h"

#include "sampling.h"

extern "C" __global__ void moveCloth(ClothMotion m) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= m.across * m.across)
        return;
    const float u = float(i % m.across) / (m.across - 1), v = float(i / m.across) / (m.across - 1);
    const float x = 4.0f * u - 2.0f, z = 4.0f * v - 2.0f, r = sqrtf(x * x + z * z);
    const float wave = 0.12f * sinf(5.0f * x + 3.0f * m.time) * cosf(4.0f * z - 2.0f * m.time) +
                       0.03f * sinf(23.0f * r - 5.0f * m.time) + 0.01f * sinf(61.0f * (x + z));
    // It hangs over a ball.
    const float over = r < 1.0f ? sqrtf(1.0f - 0.6f * r * r) : sqrtf(0.4f) - 0.55f * (r - 1.0f);
    m.vertices[i] = make_float3(x * (1.0f - 0.08f * r), over + wave * r, z * (1.0f - 0.08f * r));
}

extern "C" __global__ void findNormals(ClothMotion m) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= m.across * m.across)
        return;
    const unsigned x = i % m.across, y = i / m.across, last = m.across - 1;
    const auto at = [&](unsigned column, unsigned row) {
        return m.vertices[row * m.across + column];
    };
    const float3 across = at(x < last ? x + 1 : x, y) - at(x > 0 ? x - 1 : x, y);
    const float3 along = at(x, y < last ? y + 1 : y) - at(x, y > 0 ? y - 1 : y);
    m.normals[i] = normalize(cross(along, across));
}
