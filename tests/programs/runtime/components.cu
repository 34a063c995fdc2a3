// SPDX-License-Identifier: Apache-2.0
// Connected components of a picture by union-find in managed memory: blocks merge tiles in shared
// memory, then borders with atomicMin, then all pixels are flattened; the host reads the labels
// without a copy and compares them with a flood fill.
#include "device.h"

#include <vector>

constexpr int kWidth = 150, kHeight = 90;

template <class Pointer>
__device__ int rootOf(Pointer labels, int i) {
    while (labels[i] != i)
        i = labels[i];
    return i;
}
__device__ void merge(int* labels, int a, int b) {
    bool done = false;
    do {
        a = rootOf((volatile int*)labels, a);
        b = rootOf((volatile int*)labels, b);
        if (a < b) {
            const int old = atomicMin(&labels[b], a);
            done = old == b;
            b = old;
        } else if (b < a) {
            const int old = atomicMin(&labels[a], b);
            done = old == a;
            a = old;
        } else
            done = true;
    } while (!done);
}

__global__ void mergeTiles(const unsigned char* picture, int* labels) {
    __shared__ int tile[16 * 16];
    const int x = blockIdx.x * 16 + threadIdx.x, y = blockIdx.y * 16 + threadIdx.y;
    const int t = threadIdx.y * 16 + threadIdx.x;
    const bool inside = x < kWidth && y < kHeight;
    const int i = y * kWidth + x;
    tile[t] = t;
    __syncthreads();
    if (inside) {
        if (threadIdx.x > 0 && picture[i] == picture[i - 1])
            merge(tile, t, t - 1);
        if (threadIdx.y > 0 && picture[i] == picture[i - kWidth])
            merge(tile, t, t - 16);
    }
    __syncthreads();
    if (inside) {
        const int root = rootOf(tile, t);
        labels[i] = (blockIdx.y * 16 + root / 16) * kWidth + blockIdx.x * 16 + root % 16;
    }
}
__global__ void mergeBorders(const unsigned char* picture, int* labels) {
    const int x = blockIdx.x * 16 + threadIdx.x, y = blockIdx.y * 16 + threadIdx.y;
    if (x >= kWidth || y >= kHeight)
        return;
    const int i = y * kWidth + x;
    if (threadIdx.x == 0 && x > 0 && picture[i] == picture[i - 1])
        merge(labels, i, i - 1);
    if (threadIdx.y == 0 && y > 0 && picture[i] == picture[i - kWidth])
        merge(labels, i, i - kWidth);
}
__global__ void flatten(int* labels) {
    const int x = blockIdx.x * 16 + threadIdx.x, y = blockIdx.y * 16 + threadIdx.y;
    if (x < kWidth && y < kHeight)
        labels[y * kWidth + x] = rootOf(labels, y * kWidth + x);
}

int main() {
    unsigned char* picture;
    int* labels;
    CUDA(cudaMallocManaged(&picture, kWidth * kHeight));
    CUDA(cudaMallocManaged(&labels, kWidth * kHeight * sizeof(int)));
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const int dx = x - 70, dy = y - 40, ring = (dx * dx + dy * dy) / 160;
            picture[y * kWidth + x] = (unsigned char)((ring & 1) + ((x * 7 + y * 13) % 23 == 0));
        }
    const dim3 grid((kWidth + 15) / 16, (kHeight + 15) / 16), block(16, 16);
    mergeTiles<<<grid, block>>>(picture, labels);
    mergeBorders<<<grid, block>>>(picture, labels);
    flatten<<<grid, block>>>(labels);
    CUDA(cudaDeviceSynchronize());
    // The label of a component is its first pixel.
    std::vector<int> expected(kWidth * kHeight, -1), open;
    int wrong = 0, components = 0;
    for (int start = 0; start < kWidth * kHeight; ++start) {
        if (expected[start] < 0) {
            ++components;
            open.assign(1, start);
            expected[start] = start;
            while (!open.empty()) {
                const int i = open.back(), x = i % kWidth, y = i / kWidth;
                open.pop_back();
                const int next[] = {x > 0 ? i - 1 : i, x + 1 < kWidth ? i + 1 : i,
                                    y > 0 ? i - kWidth : i, y + 1 < kHeight ? i + kWidth : i};
                for (int n : next)
                    if (expected[n] < 0 && picture[n] == picture[i]) {
                        expected[n] = start;
                        open.push_back(n);
                    }
            }
        }
        wrong += labels[start] != expected[start];
    }
    std::printf("%d components, %d wrong\n", components, wrong);
    CUDA(cudaFree(picture));
    CUDA(cudaFree(labels));
    return finish(wrong == 0 && components > 50);
}
