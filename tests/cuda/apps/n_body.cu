// SPDX-License-Identifier: Apache-2.0
// Gravity between all pairs of bodies, tile by tile through shared memory.
#include <cuda_runtime.h>

#include "check.h"

#include <cmath>
#include <vector>

constexpr int kTile = 64;

__global__ void step(const float4* in, float4* out, float3* velocity, int n, float dt) {
    __shared__ float4 tile[kTile];
    const int i = blockIdx.x * kTile + threadIdx.x;
    const float4 own = in[i];
    float3 force = make_float3(0, 0, 0);
    for (int first = 0; first < n; first += kTile) {
        tile[threadIdx.x] = in[first + threadIdx.x];
        __syncthreads();
        for (int j = 0; j < kTile; ++j) {
            const float4 other = tile[j];
            const float dx = other.x - own.x, dy = other.y - own.y, dz = other.z - own.z;
            const float square = dx * dx + dy * dy + dz * dz + 0.01f;
            const float scale = other.w / (square * sqrtf(square));
            force.x += dx * scale;
            force.y += dy * scale;
            force.z += dz * scale;
        }
        __syncthreads();
    }
    float3 v = velocity[i];
    v.x += force.x * dt;
    v.y += force.y * dt;
    v.z += force.z * dt;
    velocity[i] = v;
    out[i] = make_float4(own.x + v.x * dt, own.y + v.y * dt, own.z + v.z * dt, own.w);
}

int main() {
    const int n = 512;
    std::vector<float4> bodies(n);
    for (int i = 0; i < n; ++i) {
        const float a = float(i) * 0.1f, r = 1 + float(i % 17) * 0.25f;
        bodies[i] = make_float4(r * std::cos(a), r * std::sin(a), float(i % 5) - 2, 1.0f / n);
    }
    float4 *in, *out;
    float3* velocity;
    CHECK(cudaMalloc(&in, n * sizeof(float4)));
    CHECK(cudaMalloc(&out, n * sizeof(float4)));
    CHECK(cudaMalloc(&velocity, n * sizeof(float3)));
    CHECK(cudaMemset(velocity, 0, n * sizeof(float3)));
    CHECK(cudaMemcpy(in, bodies.data(), n * sizeof(float4), cudaMemcpyHostToDevice));
    for (int k = 0; k < 10; ++k) {
        step<<<n / kTile, kTile>>>(in, out, velocity, n, 0.05f);
        CHECK(cudaGetLastError());
        std::swap(in, out);
    }
    CHECK(cudaMemcpy(bodies.data(), in, n * sizeof(float4), cudaMemcpyDeviceToHost));
    double center[3] = {};
    for (const float4& b : bodies) {
        center[0] += double(b.x) * b.w;
        center[1] += double(b.y) * b.w;
        center[2] += double(b.z) * b.w;
    }
    for (int i : {0, 100, 511})
        std::printf("%.3f %.3f %.3f\n", bodies[i].x, bodies[i].y, bodies[i].z);
    std::printf("%.3f %.3f %.3f\n", center[0], center[1], center[2]);
    return 0;
}
