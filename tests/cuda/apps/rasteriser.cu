// SPDX-License-Identifier: Apache-2.0
// A software rasteriser: a thread for each triangle walks over its pixels and keeps the nearest by
// atomicMin on depth and number in 64 bits; large triangles go through a queue to a kernel with a
// block for each. Coordinates are integers, so that coverage and depth are exact.
#include <cuda_runtime.h>

#include "check.h"
#include "clock.h"

#include <algorithm>
#include <vector>

constexpr int kLarge = 1024; // pixels of the box around a triangle

struct Vertex {
    int x, y, z;
};
struct Triangle {
    Vertex corners[3];
};

struct Picture {
    int width, height;
    unsigned long long* pixels;
};

__host__ __device__ inline int least(int a, int b) {
    return a < b ? a : b;
}
__host__ __device__ inline int most(int a, int b) {
    return a > b ? a : b;
}

struct Setup {
    int left, right, top, bottom; // inclusive
    int dx[3], dy[3];             // steps of the edges
    long long area;
    Vertex corners[3];

    __host__ __device__ bool begin(const Triangle& triangle, int width, int height) {
        for (int i = 0; i < 3; ++i)
            corners[i] = triangle.corners[i];
        const Vertex &a = corners[0], &b = corners[1], &c = corners[2];
        area = (long long)(b.x - a.x) * (c.y - a.y) - (long long)(b.y - a.y) * (c.x - a.x);
        if (area <= 0)
            return false; // seen from behind, or a line
        left = most(0, least(a.x, least(b.x, c.x)));
        right = least(width - 1, most(a.x, most(b.x, c.x)));
        top = most(0, least(a.y, least(b.y, c.y)));
        bottom = least(height - 1, most(a.y, most(b.y, c.y)));
        for (int i = 0; i < 3; ++i) {
            const Vertex &from = corners[(i + 1) % 3], &to = corners[(i + 2) % 3];
            dx[i] = to.x - from.x;
            dy[i] = to.y - from.y;
        }
        return left <= right && top <= bottom;
    }
    // The pixel's depth and the triangle's number, or all ones where it is not covered.
    __host__ __device__ unsigned long long at(int x, int y, unsigned number) const {
        long long sum = 0;
        for (int i = 0; i < 3; ++i) {
            const Vertex& from = corners[(i + 1) % 3];
            const int weight = dx[i] * (y - from.y) - dy[i] * (x - from.x);
            // Edges that two triangles share belong to one of them.
            const bool owns = dy[i] > 0 || (dy[i] == 0 && dx[i] < 0);
            if (weight < 0 || (weight == 0 && !owns))
                return ~0ull;
            sum += (long long)weight * corners[i].z;
        }
        return (unsigned long long)(sum / area) << 32 | number;
    }
};

__global__ void clear(Picture picture) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x, y = blockIdx.y * blockDim.y + threadIdx.y;
    if (x < picture.width && y < picture.height)
        picture.pixels[y * picture.width + x] = ~0ull;
}

__global__ void drawSmall(const Triangle* triangles, int count, Picture picture, int* queue,
                          int* queued) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    Setup setup;
    if (i >= count || !setup.begin(triangles[i], picture.width, picture.height))
        return;
    if ((setup.right - setup.left + 1) * (setup.bottom - setup.top + 1) > kLarge) {
        queue[atomicAdd(queued, 1)] = i;
        return;
    }
    for (int y = setup.top; y <= setup.bottom; ++y)
        for (int x = setup.left; x <= setup.right; ++x) {
            const unsigned long long made = setup.at(x, y, unsigned(i));
            if (made != ~0ull)
                atomicMin(&picture.pixels[y * picture.width + x], made);
        }
}

__global__ void drawLarge(const Triangle* triangles, Picture picture, const int* queue,
                          const int* queued) {
    for (int q = blockIdx.x; q < *queued; q += gridDim.x) {
        const int i = queue[q];
        Setup setup;
        setup.begin(triangles[i], picture.width, picture.height);
        for (int y = setup.top + int(threadIdx.y); y <= setup.bottom; y += blockDim.y)
            for (int x = setup.left + int(threadIdx.x); x <= setup.right; x += blockDim.x) {
                const unsigned long long made = setup.at(x, y, unsigned(i));
                if (made != ~0ull)
                    atomicMin(&picture.pixels[y * picture.width + x], made);
            }
    }
}

int main(int argc, char** argv) {
    Clock clock(argc, argv);
    const int width = 640, height = 360, count = 3000 * clock.factor();
    std::vector<Triangle> triangles(count);
    unsigned state = 4321;
    const auto random = [&](int below) {
        state = state * 1664525u + 1013904223u;
        return int((state >> 8) % unsigned(below));
    };
    for (Triangle& triangle : triangles) {
        const int reach = random(20) == 0 ? 150 : 14;
        const int x = random(width), y = random(height), z = random(1 << 20);
        for (Vertex& corner : triangle.corners)
            corner = {x + random(2 * reach) - reach, y + random(2 * reach) - reach,
                      z + random(1 << 16)};
    }
    Triangle* device;
    Picture picture{width, height, nullptr};
    int *queue, *queued;
    const size_t pixels = size_t(width) * height;
    CHECK(cudaMalloc(&device, count * sizeof(Triangle)));
    CHECK(cudaMalloc(&picture.pixels, pixels * sizeof(unsigned long long)));
    CHECK(cudaMalloc(&queue, count * sizeof(int)));
    CHECK(cudaMalloc(&queued, sizeof(int)));
    CHECK(cudaMemcpy(device, triangles.data(), count * sizeof(Triangle), cudaMemcpyHostToDevice));
    for (int round = 0; round < 2; ++round) { // the first one compiles
        clock.start();
        CHECK(cudaMemset(queued, 0, sizeof(int)));
        const dim3 block(32, 8), grid((width + 31) / 32, (height + 7) / 8);
        clear<<<grid, block>>>(picture);
        drawSmall<<<(count + 127) / 128, 128>>>(device, count, picture, queue, queued);
        drawLarge<<<64, block>>>(device, picture, queue, queued);
        CHECK(cudaDeviceSynchronize());
        clock.kernels();
    }
    std::vector<unsigned long long> made(pixels), expected(pixels, ~0ull);
    CHECK(cudaMemcpy(made.data(), picture.pixels, pixels * sizeof(unsigned long long),
                     cudaMemcpyDeviceToHost));
    int large = 0;
    CHECK(cudaMemcpy(&large, queued, sizeof large, cudaMemcpyDeviceToHost));
    clock.start();
    for (int i = 0; i < count; ++i) {
        Setup setup;
        if (!setup.begin(triangles[i], width, height))
            continue;
        for (int y = setup.top; y <= setup.bottom; ++y)
            for (int x = setup.left; x <= setup.right; ++x) {
                unsigned long long& pixel = expected[size_t(y) * width + x];
                pixel = std::min(pixel, setup.at(x, y, unsigned(i)));
            }
    }
    clock.host("rasteriser");
    size_t wrong = 0, covered = 0;
    unsigned hash = 2166136261u;
    for (size_t i = 0; i < pixels; ++i) {
        wrong += made[i] != expected[i];
        covered += made[i] != ~0ull;
        hash = (hash ^ unsigned(made[i]) ^ unsigned(made[i] >> 32)) * 16777619u;
    }
    std::printf("%zu of %zu pixels wrong, %zu covered, %d large triangles, hash %08x\n", wrong,
                pixels, covered, large, hash);
    return 0;
}
