// SPDX-License-Identifier: Apache-2.0
// What nvcc accepts and clang alone refuses: a register's name behind a single %, narrowing.
extern "C" __constant__ float table[4];

__global__ void dialect(float3* to) {
    int lane;
    asm volatile("mov.u32 %0, %laneid;" : "=r"(lane));
    float3 value = {lane, lane + 1, table[lane % 4]};
    *to = value;
}
