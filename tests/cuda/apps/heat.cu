// SPDX-License-Identifier: Apache-2.0
// Heat diffusion on a plate in one cooperative launch: all blocks do a step, meet at a barrier of
// the grid, and do the next one. Tiles with their borders go through shared memory. Integers.
#include <cooperative_groups.h>
#include <cuda_runtime.h>

#include "check.h"
#include "clock.h"

#include <vector>

constexpr int kTile = 16;

__host__ __device__ inline int spread(int here, int left, int right, int up, int down) {
    return here + ((left + right + up + down - 4 * here) >> 3);
}

__global__ void heat(int* plates, int width, int height, int steps) {
    __shared__ int tile[kTile + 2][kTile + 2];
    cooperative_groups::grid_group grid = cooperative_groups::this_grid();
    const int acrossTiles = (width + kTile - 1) / kTile,
              tiles = acrossTiles * ((height + kTile - 1) / kTile);
    const auto clamp = [](int value, int most) {
        return value < 0 ? 0 : value > most ? most : value;
    };
    const int tx = int(threadIdx.x), ty = int(threadIdx.y);
    for (int step = 0; step < steps; ++step) {
        const int* from = plates + size_t(step % 2) * width * height;
        int* to = plates + size_t(1 - step % 2) * width * height;
        for (int t = blockIdx.x; t < tiles; t += gridDim.x) {
            const int left = t % acrossTiles * kTile, top = t / acrossTiles * kTile;
            for (int i = ty * kTile + tx; i < (kTile + 2) * (kTile + 2); i += kTile * kTile) {
                const int x = clamp(left + i % (kTile + 2) - 1, width - 1);
                const int y = clamp(top + i / (kTile + 2) - 1, height - 1);
                tile[i / (kTile + 2)][i % (kTile + 2)] = from[y * width + x];
            }
            __syncthreads();
            if (left + tx < width && top + ty < height)
                to[(top + ty) * width + left + tx] =
                    spread(tile[ty + 1][tx + 1], tile[ty + 1][tx], tile[ty + 1][tx + 2],
                           tile[ty][tx + 1], tile[ty + 2][tx + 1]);
            __syncthreads();
        }
        grid.sync();
    }
}

int main(int argc, char** argv) {
    Clock clock(argc, argv);
    int width = 250, height = 60 * clock.factor(), steps = 20;
    const size_t all = size_t(width) * height;
    std::vector<int> plates(2 * all), made(all);
    for (size_t i = 0; i < all; ++i)
        plates[i] = int(i * 7919 % 1000003);
    int* device;
    CHECK(cudaMalloc(&device, 2 * all * sizeof(int)));
    int perProcessor = 0, processors = 0;
    CHECK(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&perProcessor, heat, kTile * kTile, 0));
    CHECK(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, 0));
    const int blocks = perProcessor * processors < 12 ? perProcessor * processors : 12;
    for (int round = 0; round < 2; ++round) { // the first one compiles
        CHECK(cudaMemcpy(device, plates.data(), all * sizeof(int), cudaMemcpyHostToDevice));
        clock.start();
        void* arguments[] = {&device, &width, &height, &steps};
        CHECK(cudaLaunchCooperativeKernel(reinterpret_cast<void*>(heat), dim3(blocks),
                                          dim3(kTile, kTile), arguments, 0, 0));
        CHECK(cudaDeviceSynchronize());
        clock.kernels();
    }
    CHECK(cudaMemcpy(made.data(), device + size_t(steps % 2) * all, all * sizeof(int),
                     cudaMemcpyDeviceToHost));
    clock.start();
    for (int step = 0; step < steps; ++step) {
        const int* from = &plates[step % 2 * all];
        int* to = &plates[(1 - step % 2) * all];
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                to[y * width + x] =
                    spread(from[y * width + x], from[y * width + (x > 0 ? x - 1 : 0)],
                           from[y * width + (x + 1 < width ? x + 1 : x)],
                           from[(y > 0 ? y - 1 : 0) * width + x],
                           from[(y + 1 < height ? y + 1 : y) * width + x]);
    }
    clock.host("heat");
    size_t wrong = 0;
    long long sum = 0;
    for (size_t i = 0; i < all; ++i) {
        wrong += made[i] != plates[steps % 2 * all + i];
        sum += made[i];
    }
    std::printf("%zu of %zu wrong, sum %lld\n", wrong, all, sum);
    return 0;
}
