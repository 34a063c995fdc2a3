// SPDX-License-Identifier: Apache-2.0
// A puzzle solver with persistent threads: warps take work from a counter by their leader and a
// shuffle, search with a stack of their own, and add up solutions by shuffles;
// checked against the known numbers of queens.
#include "device.h"

__device__ unsigned nextItem;
__device__ unsigned long long solutions;

// Items are the places of the first three queens.
__global__ void solve(int n) {
    const unsigned lane = threadIdx.x & 31, items = n * n * n;
    unsigned long long mine = 0;
    for (;;) {
        unsigned base = 0;
        if (lane == 0)
            base = atomicAdd(&nextItem, 32);
        base = __shfl_sync(0xffffffffu, base, 0);
        if (base >= items)
            break;
        unsigned item = base + lane;
        if (item >= items)
            continue;
        unsigned columns = 0, left = 0, right = 0;
        bool possible = true;
        for (int row = 0; row < 3; ++row, item /= n) {
            const unsigned bit = 1u << (item % n);
            possible = possible && !(bit & (columns | left | right));
            columns |= bit;
            left = (left | bit) << 1;
            right = (right | bit) >> 1;
        }
        if (!possible)
            continue;
        unsigned stack[16][4];
        const unsigned all = (1u << n) - 1;
        int depth = 0;
        stack[0][0] = columns, stack[0][1] = left, stack[0][2] = right;
        stack[0][3] = all & ~(columns | left | right);
        while (depth >= 0) {
            unsigned* s = stack[depth];
            if (s[0] == all) {
                ++mine;
                --depth;
                continue;
            }
            const unsigned bit = s[3] & (0u - s[3]);
            if (!bit) {
                --depth;
                continue;
            }
            s[3] ^= bit;
            unsigned* t = stack[++depth];
            t[0] = s[0] | bit;
            t[1] = (s[1] | bit) << 1;
            t[2] = (s[2] | bit) >> 1;
            t[3] = all & ~(t[0] | t[1] | t[2]);
        }
    }
    for (int step = 16; step; step /= 2)
        mine += __shfl_down_sync(0xffffffffu, mine, step);
    if (lane == 0 && mine)
        atomicAdd(&solutions, mine);
}

int main() {
    const unsigned long long known[] = {0, 0, 0, 0, 2, 10, 4, 40, 92, 352};
    int wrong = 0;
    for (int n = 4; n < 10; ++n) {
        const unsigned zero = 0;
        unsigned long long count = 0;
        CUDA(cudaMemcpyToSymbol(nextItem, &zero, sizeof(zero)));
        CUDA(cudaMemcpyToSymbol(solutions, &count, sizeof(count)));
        solve<<<3, 64>>>(n);
        CUDA(cudaMemcpyFromSymbol(&count, solutions, sizeof(count)));
        std::printf("%d queens: %llu\n", n, count);
        wrong += count != known[n];
    }
    return finish(wrong == 0);
}
