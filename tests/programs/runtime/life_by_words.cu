// SPDX-License-Identifier: Apache-2.0
// The game of life, 32 cells in a word: neighbours come from other lanes by shuffles, sums of nine
// cells from bitwise adders, halves of rows by funnel shifts. A second kernel plays it with a
// ballot for each row, and a third with bytes in tiles of shared memory with dynamic size. All must
// agree.
#include "device.h"

#include <cstring>
#include <utility>
#include <vector>

constexpr int kWords = 32, kRows = 96; // a torus of 1024 by 96

__device__ void add(unsigned& ones, unsigned& twos, unsigned& fours, unsigned x) {
    const unsigned c1 = ones & x;
    ones ^= x;
    const unsigned c2 = twos & c1;
    twos ^= c1;
    fours |= c2;
}

__device__ unsigned next(unsigned self, const unsigned (&around)[8]) {
    unsigned ones = 0, twos = 0, fours = 0;
#pragma unroll
    for (int i = 0; i < 8; ++i)
        add(ones, twos, fours, around[i]);
    return twos & ~fours & (ones | self);
}

__global__ void byShuffles(const unsigned* in, unsigned* out) {
    const int lane = threadIdx.x, row = blockIdx.x * blockDim.y + threadIdx.y;
    if (row >= kRows)
        return;
    unsigned words[3], around[8];
    int k = 0;
    for (int d = -1; d <= 1; ++d) {
        const unsigned word = in[(row + d + kRows) % kRows * kWords + lane];
        const unsigned left = __shfl_sync(~0u, word, lane + 31),
                       right = __shfl_sync(~0u, word, lane + 1);
        words[d + 1] = word;
        around[k++] = __funnelshift_l(left, word, 1);
        around[k++] = __funnelshift_r(word, right, 1);
        if (d)
            around[k++] = word;
    }
    out[row * kWords + lane] = next(words[1], around);
}

__global__ void byBallots(const unsigned* in, unsigned* out) {
    // A block for each word, 32 lanes for its cells.
    const int word = blockIdx.x % kWords, row = blockIdx.x / kWords, lane = threadIdx.x;
    int sum = 0;
    const auto cell = [&](int dx, int dy) {
        const int x = (word * 32 + lane + dx + kWords * 32) % (kWords * 32),
                  y = (row + dy + kRows) % kRows;
        return int(in[y * kWords + x / 32] >> (x % 32) & 1);
    };
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            sum += dx || dy ? cell(dx, dy) : 0;
    const unsigned bits = __ballot_sync(__activemask(), sum == 3 || (sum == 2 && cell(0, 0)));
    if (lane == 0)
        out[blockIdx.x] = bits;
}

__global__ void byTiles(const unsigned char* in, unsigned char* out, int wide, int high) {
    extern __shared__ unsigned char tile[];
    const int pitch = blockDim.x + 2;
    const int x0 = blockIdx.x * blockDim.x - 1, y0 = blockIdx.y * blockDim.y - 1;
    for (int i = threadIdx.y * blockDim.x + threadIdx.x; i < pitch * int(blockDim.y + 2);
         i += blockDim.x * blockDim.y)
        tile[i] = in[(y0 + i / pitch + high) % high * wide + (x0 + i % pitch + wide) % wide];
    __syncthreads();
    const unsigned char* c = tile + (threadIdx.y + 1) * pitch + threadIdx.x + 1;
    const int sum = c[-pitch - 1] + c[-pitch] + c[-pitch + 1] + c[-1] + c[1] + c[pitch - 1] +
                    c[pitch] + c[pitch + 1];
    out[(y0 + 1 + threadIdx.y) * wide + x0 + 1 + threadIdx.x] = sum == 3 || (sum == 2 && *c);
}

int main() {
    constexpr int kCells = kWords * 32 * kRows, kSteps = 10;
    std::vector<unsigned> world(kWords * kRows), first(world.size()), second(world.size());
    unsigned state = 99;
    for (unsigned& word : world)
        for (int b = 0; b < 32; ++b) {
            state = state * 1664525u + 1013904223u;
            word |= unsigned((state >> 24) % 3 == 0) << b;
        }
    std::vector<unsigned char> cells(kCells);
    for (int i = 0; i < kCells; ++i)
        cells[i] = world[i / 32] >> (i % 32) & 1;
    unsigned *a[2], *b[2];
    unsigned char* c[2];
    for (int i = 0; i < 2; ++i) {
        CUDA(cudaMalloc(&a[i], world.size() * 4));
        CUDA(cudaMalloc(&b[i], world.size() * 4));
        CUDA(cudaMalloc(&c[i], kCells));
    }
    CUDA(cudaMemcpy(a[0], world.data(), world.size() * 4, cudaMemcpyHostToDevice));
    CUDA(cudaMemcpy(b[0], world.data(), world.size() * 4, cudaMemcpyHostToDevice));
    CUDA(cudaMemcpy(c[0], cells.data(), kCells, cudaMemcpyHostToDevice));
    for (int step = 0; step < kSteps; ++step) {
        byShuffles<<<kRows / 4, dim3(32, 4)>>>(a[0], a[1]);
        byBallots<<<kWords * kRows, 32>>>(b[0], b[1]);
        byTiles<<<dim3(kWords, kRows / 8), dim3(32, 8), 34 * 10>>>(c[0], c[1], kWords * 32, kRows);
        std::swap(a[0], a[1]);
        std::swap(b[0], b[1]);
        std::swap(c[0], c[1]);
    }
    CUDA(cudaMemcpy(first.data(), a[0], first.size() * 4, cudaMemcpyDeviceToHost));
    CUDA(cudaMemcpy(second.data(), b[0], second.size() * 4, cudaMemcpyDeviceToHost));
    std::vector<unsigned char> third(kCells), next(kCells);
    CUDA(cudaMemcpy(third.data(), c[0], kCells, cudaMemcpyDeviceToHost));
    for (int step = 0; step < kSteps; ++step) {
        for (int i = 0; i < kCells; ++i) {
            const int w = kWords * 32, x = i % w, y = i / w;
            int sum = 0;
            for (int d = 0; d < 9; ++d)
                if (d != 4)
                    sum += cells[(y + d / 3 - 1 + kRows) % kRows * w + (x + d % 3 - 1 + w) % w];
            next[i] = sum == 3 || (sum == 2 && cells[i]);
        }
        std::swap(cells, next);
    }
    int wrong = 0, alive = 0;
    for (int i = 0; i < kCells; ++i) {
        alive += cells[i];
        wrong += (first[i / 32] >> (i % 32) & 1) != cells[i];
        wrong += (second[i / 32] >> (i % 32) & 1) != cells[i];
        wrong += third[i] != cells[i];
    }
    std::printf("%d wrong, %d alive\n", wrong, alive);
    return finish(wrong == 0 && alive > 1000);
}
