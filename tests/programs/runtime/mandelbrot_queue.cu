// SPDX-License-Identifier: Apache-2.0
// Mandelbrot with work that is made while it is done: tiles whose border has one value are filled,
// others are split in four. Warps take tiles from a queue in memory with atomics and wait for tiles
// that others still make. All kinds of pixels must be those of the plain loop.
#include "device.h"

#include <vector>

constexpr int kSide = 192, kMost = 96, kLargest = 48, kSmallest = 6, kCapacity = 8192;

struct Tile {
    short x, y, size, ready;
};
struct Queue {
    Tile tiles[kCapacity];
    int begin, end, open; // tiles taken, tiles made, tiles that are not yet done
    int filled, split;
};

__host__ __device__ inline int iterations(int px, int py) {
    // Multiples of a power of two, so that no product rounds differently.
    const double cx = (px - 144) / 64.0, cy = (py - 96) / 64.0;
    double x = 0, y = 0;
    for (int i = 0; i < kMost; ++i) {
        const double xx = x * x, yy = y * y;
        if (xx + yy > 4)
            return i;
        y = 2 * (x * y) + cy;
        x = xx - yy + cx;
    }
    return kMost;
}

__device__ void push(Queue* queue, int x, int y, int size) {
    atomicAdd(&queue->open, 1);
    const int at = atomicAdd(&queue->end, 1);
    Tile* tile = &queue->tiles[at];
    tile->x = short(x);
    tile->y = short(y);
    tile->size = short(size);
    __threadfence();
    *reinterpret_cast<volatile short*>(&tile->ready) = 1;
}

__device__ bool borderIsUniform(const Tile& tile, int* image, int lane, int* value) {
    const int edge = 4 * (tile.size - 1);
    int low = kMost + 1, high = -1;
    for (int i = lane; i < edge; i += 32) {
        const int side = i / (tile.size - 1), along = i % (tile.size - 1), last = tile.size - 1;
        const int x = tile.x + (side == 0   ? along
                                : side == 1 ? last
                                : side == 2 ? last - along
                                            : 0);
        const int y = tile.y + (side == 0   ? 0
                                : side == 1 ? along
                                : side == 2 ? last
                                            : last - along);
        const int n = iterations(x, y);
        image[y * kSide + x] = n;
        low = min(low, n);
        high = max(high, n);
    }
    for (int step = 16; step > 0; step /= 2) {
        low = min(low, __shfl_xor_sync(~0u, low, step));
        high = max(high, __shfl_xor_sync(~0u, high, step));
    }
    *value = low;
    return low == high && low == kMost; // the inside has no holes
}

__global__ void work(Queue* queue, int* image) {
    const int lane = threadIdx.x % 32;
    for (;;) {
        int at = -1;
        if (lane == 0) {
            // Take the next tile, or leave when nobody makes any more.
            for (;;) {
                const int next = atomicAdd(&queue->begin, 0);
                if (next < atomicAdd(&queue->end, 0)) {
                    if (atomicCAS(&queue->begin, next, next + 1) == next) {
                        at = next;
                        break;
                    }
                } else if (atomicAdd(&queue->open, 0) == 0) {
                    break;
                }
            }
            if (at >= 0)
                while (!*reinterpret_cast<volatile short*>(&queue->tiles[at].ready)) {
                }
            __threadfence();
        }
        at = __shfl_sync(~0u, at, 0);
        if (at < 0)
            return;
        const Tile tile = queue->tiles[at];
        int value;
        const bool isUniform = borderIsUniform(tile, image, lane, &value);
        const int inner = tile.size - 2;
        if (isUniform || tile.size <= kSmallest) {
            for (int i = lane; i < inner * inner; i += 32) {
                const int x = tile.x + 1 + i % inner, y = tile.y + 1 + i / inner;
                image[y * kSide + x] = isUniform ? value : iterations(x, y);
            }
            if (lane == 0 && isUniform)
                atomicAdd(&queue->filled, 1);
        } else if (lane == 0) {
            const int half = tile.size / 2;
            for (int k = 0; k < 4; ++k)
                push(queue, tile.x + k % 2 * half, tile.y + k / 2 * half, half);
            atomicAdd(&queue->split, 1);
        }
        __syncwarp();
        if (lane == 0) {
            __threadfence();
            atomicSub(&queue->open, 1);
        }
    }
}

int main() {
    Queue* queue;
    int* image;
    CUDA(cudaMallocManaged(&queue, sizeof(Queue)));
    CUDA(cudaMalloc(&image, kSide * kSide * sizeof(int)));
    CUDA(cudaMemset(image, 0xff, kSide * kSide * sizeof(int)));
    *queue = {};
    for (int y = 0; y < kSide; y += kLargest)
        for (int x = 0; x < kSide; x += kLargest)
            queue->tiles[queue->end++] = {short(x), short(y), kLargest, 1};
    queue->open = queue->end;
    work<<<4, 128>>>(queue, image);
    std::vector<int> seen(kSide * kSide);
    CUDA(cudaMemcpy(seen.data(), image, seen.size() * 4, cudaMemcpyDeviceToHost));
    int wrong = 0;
    for (int i = 0; i < kSide * kSide; ++i)
        wrong += seen[i] != iterations(i % kSide, i / kSide);
    std::printf("%d wrong, %d tiles, %d filled, %d split\n", wrong, queue->end, queue->filled,
                queue->split);
    return finish(wrong == 0 && queue->filled > 5 && queue->end == 16 + 4 * queue->split &&
                  queue->open == 0);
}
