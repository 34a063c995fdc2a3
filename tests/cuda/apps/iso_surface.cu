// SPDX-License-Identifier: Apache-2.0
// The isosurface of a scalar field as triangles, cell by cell: a kernel counts the triangles of
// each cell, a scan turns the counts into places, and another kernel writes the triangles there.
// Each cell is cut into six tetrahedra. Vertices lie on an integer grid, so that host and device
// agree in every bit.
#include <cuda_runtime.h>

#include "check.h"
#include "clock.h"

#include <algorithm>
#include <vector>

constexpr int kThreads = 256, kEach = 4, kTile = kThreads * kEach, kLevel = 1 << 20;

struct Corner {
    int x, y, z;
    __host__ __device__ bool operator==(const Corner& o) const {
        return x == o.x && y == o.y && z == o.z;
    }
};
struct Facet {
    Corner corners[3];
    bool operator==(const Facet& o) const {
        return corners[0] == o.corners[0] && corners[1] == o.corners[1] &&
               corners[2] == o.corners[2];
    }
};

// Corners of a cell: bit 0 is x, bit 1 y, bit 2 z. Every tetrahedron has the diagonal from 0 to 7.
__host__ __device__ inline int cornerOf(int tetrahedron, int i) {
    constexpr unsigned kMiddles[6] = {0x31, 0x23, 0x62, 0x46, 0x54, 0x15};
    return i == 0 ? 0 : i == 3 ? 7 : int(kMiddles[tetrahedron] >> (i == 1 ? 0 : 4) & 15);
}

struct Field {
    int size; // samples along each side
    const int* values;
    __host__ __device__ int cells() const { return (size - 1) * (size - 1) * (size - 1); }
    __host__ __device__ Corner cell(int number) const {
        const int side = size - 1;
        return {number % side, number / side % side, number / side / side};
    }
    __host__ __device__ int at(Corner cell, int corner) const {
        return values[((cell.z + (corner >> 2)) * size + cell.y + (corner >> 1 & 1)) * size +
                      cell.x + (corner & 1)];
    }
    __host__ __device__ unsigned insides(int number) const {
        const Corner here = cell(number);
        unsigned bits = 0;
        for (int corner = 0; corner < 8; ++corner)
            bits |= unsigned(at(here, corner) < kLevel) << corner;
        return bits;
    }
};

__host__ __device__ inline unsigned shapeOf(unsigned insides, int tetrahedron) {
    unsigned shape = 0;
    for (int i = 0; i < 4; ++i)
        shape |= (insides >> cornerOf(tetrahedron, i) & 1u) << i;
    return shape;
}

__host__ __device__ inline int countOf(unsigned insides) {
    int count = 0;
    for (int t = 0; t < 6; ++t) {
        const unsigned shape = shapeOf(insides, t);
        int ones = 0;
        for (int i = 0; i < 4; ++i)
            ones += shape >> i & 1;
        count += ones == 2 ? 2 : ones % 4 != 0;
    }
    return count;
}

// Where the surface crosses the edge between two corners of a cell, in 256ths of a cell.
__host__ __device__ inline Corner crossing(const Field& field, Corner cell, int from, int to) {
    const long long a = field.at(cell, from), b = field.at(cell, to);
    const int part = int((kLevel - a) * 256 / (b - a));
    const auto place = [&](int axis, int base) {
        const int first = from >> axis & 1, last = to >> axis & 1;
        return (base + first) * 256 + (last - first) * part;
    };
    return {place(0, cell.x), place(1, cell.y), place(2, cell.z)};
}

__host__ __device__ inline void facets(const Field& field, int number, Facet* out) {
    const unsigned insides = field.insides(number);
    const Corner cell = field.cell(number);
    for (int t = 0; t < 6; ++t) {
        const unsigned shape = shapeOf(insides, t);
        int in[4], outside[4], ins = 0, outs = 0;
        for (int i = 0; i < 4; ++i)
            if (shape >> i & 1)
                in[ins++] = cornerOf(t, i);
            else
                outside[outs++] = cornerOf(t, i);
        if (ins == 1 || ins == 3) {
            const int* many = ins == 1 ? outside : in;
            const int one = ins == 1 ? in[0] : outside[0];
            for (int i = 0; i < 3; ++i)
                out->corners[i] = crossing(field, cell, one, many[i]);
            ++out;
        } else if (ins == 2) {
            const Corner a = crossing(field, cell, in[0], outside[0]);
            const Corner b = crossing(field, cell, in[0], outside[1]);
            const Corner c = crossing(field, cell, in[1], outside[0]);
            const Corner d = crossing(field, cell, in[1], outside[1]);
            *out++ = {{a, b, d}};
            *out++ = {{a, d, c}};
        }
    }
}

__global__ void countFacets(Field field, int* counts) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < field.cells())
        counts[i] = countOf(field.insides(i));
}

// Exclusive sums of each tile, in place, and the sum of the tile. Several tiles: sums of those.
__global__ void scanTiles(int* counts, int n, int* sums) {
    __shared__ int warps[kThreads / 32];
    const int first = blockIdx.x * kTile + threadIdx.x * kEach;
    const int lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    int own[kEach], sum = 0;
    for (int k = 0; k < kEach; ++k) {
        own[k] = sum;
        sum += first + k < n ? counts[first + k] : 0;
    }
    int running = sum;
    for (int distance = 1; distance < 32; distance *= 2) {
        const int left = __shfl_up_sync(0xffffffffu, running, distance);
        running += lane >= distance ? left : 0;
    }
    if (lane == 31)
        warps[warp] = running;
    __syncthreads();
    if (warp == 0) {
        int total = lane < kThreads / 32 ? warps[lane] : 0;
        for (int distance = 1; distance < kThreads / 32; distance *= 2) {
            const int left = __shfl_up_sync(0xffffffffu, total, distance);
            total += lane >= distance ? left : 0;
        }
        if (lane < kThreads / 32)
            warps[lane] = total;
    }
    __syncthreads();
    const int before = (warp > 0 ? warps[warp - 1] : 0) + running - sum;
    for (int k = 0; k < kEach; ++k)
        if (first + k < n)
            counts[first + k] = before + own[k];
    if (threadIdx.x == kThreads - 1)
        sums[blockIdx.x] = before + sum;
}

__global__ void addSums(int* counts, int n, const int* sums) {
    const int before = sums[blockIdx.x];
    for (int i = blockIdx.x * kTile + threadIdx.x, k = 0; k < kEach && i < n; ++k, i += kThreads)
        counts[i] += before;
}

__global__ void writeFacets(Field field, const int* places, Facet* out) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < field.cells())
        facets(field, i, out + places[i]);
}

// Sums of tiles need as many levels as it takes.
void scan(int* counts, int n, std::vector<int*>& levels, size_t level) {
    const int tiles = (n + kTile - 1) / kTile;
    if (level == levels.size()) {
        levels.push_back(nullptr);
        CHECK(cudaMalloc(&levels.back(), tiles * sizeof(int)));
    }
    int* sums = levels[level];
    scanTiles<<<tiles, kThreads>>>(counts, n, sums);
    if (tiles == 1)
        return;
    scan(sums, tiles, levels, level + 1);
    addSums<<<tiles, kThreads>>>(counts, n, sums);
}

int main(int argc, char** argv) {
    Clock clock(argc, argv);
    const int size = 33 + 8 * (clock.factor() - 1);
    std::vector<int> values(size_t(size) * size * size);
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const int a = 256 * x / size - 128, b = 256 * y / size - 128,
                          c = 256 * z / size - 128;
                values[(size_t(z) * size + y) * size + x] =
                    (a * a + b * b + c * c) * 90 + (a * b ^ b * c ^ c * a) * 17;
            }
    Field field{size, nullptr};
    const int cells = field.cells();
    int *device, *counts;
    Facet* out = nullptr;
    CHECK(cudaMalloc(&device, values.size() * sizeof(int)));
    CHECK(cudaMalloc(&counts, (cells + 1) * sizeof(int)));
    CHECK(cudaMemcpy(device, values.data(), values.size() * sizeof(int), cudaMemcpyHostToDevice));
    field.values = device;
    std::vector<int*> levels;
    int total = 0;
    for (int round = 0; round < 2; ++round) { // the first one compiles
        clock.start();
        CHECK(cudaMemset(counts + cells, 0, sizeof(int)));
        countFacets<<<(cells + 255) / 256, 256>>>(field, counts);
        scan(counts, cells + 1, levels, 0);
        CHECK(cudaMemcpy(&total, counts + cells, sizeof(int), cudaMemcpyDeviceToHost));
        if (!out)
            CHECK(cudaMalloc(&out, total * sizeof(Facet)));
        writeFacets<<<(cells + 255) / 256, 256>>>(field, counts, out);
        CHECK(cudaDeviceSynchronize());
        clock.kernels();
    }
    std::vector<Facet> made(total), expected;
    CHECK(cudaMemcpy(made.data(), out, total * sizeof(Facet), cudaMemcpyDeviceToHost));
    field.values = values.data();
    clock.start();
    for (int i = 0; i < cells; ++i)
        if (const int count = countOf(field.insides(i))) {
            expected.resize(expected.size() + count);
            facets(field, i, &expected[expected.size() - count]);
        }
    clock.host("surface");
    long long middle[3] = {};
    for (const Facet& facet : made)
        for (const Corner& corner : facet.corners) {
            middle[0] += corner.x;
            middle[1] += corner.y;
            middle[2] += corner.z;
        }
    std::printf("%d triangles, %s; sums of corners %lld %lld %lld\n", total,
                made == expected ? "as on the host" : "WRONG", middle[0], middle[1], middle[2]);
    return 0;
}
