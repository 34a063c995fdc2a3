// SPDX-License-Identifier: Apache-2.0
// A lattice Boltzmann solver in double precision (nine directions, structure of arrays, an obstacle
// that bounces flow back), pointers exchanged each step; one source for host and device, compared
// cell by cell, and mass must be conserved.
#include "device.h"

#include <cmath>
#include <utility>
#include <vector>

constexpr int kX = 48, kY = 32, kCells = kX * kY, kSteps = 40;

struct Lattice {
    double* f[9];
    const unsigned char* solid;
};

__host__ __device__ inline void step(const Lattice& from, const Lattice& to, int cell) {
    const int dx[9] = {0, 1, 0, -1, 0, 1, -1, -1, 1};
    const int dy[9] = {0, 0, 1, 0, -1, 1, 1, -1, -1};
    const int opposite[9] = {0, 3, 4, 1, 2, 7, 8, 5, 6};
    const double weight[9] = {4.0 / 9,  1.0 / 9,  1.0 / 9,  1.0 / 9, 1.0 / 9,
                              1.0 / 36, 1.0 / 36, 1.0 / 36, 1.0 / 36};
    const int x = cell % kX, y = cell / kX;
    double f[9], density = 0, vx = 0, vy = 0;
    for (int q = 0; q < 9; ++q) {
        const int source = (y - dy[q] + kY) % kY * kX + (x - dx[q] + kX) % kX;
        f[q] = from.solid[source] ? from.f[opposite[q]][cell] : from.f[q][source];
        density += f[q];
        vx += f[q] * dx[q];
        vy += f[q] * dy[q];
    }
    vx /= density;
    vy /= density;
    const double square = 1.5 * (vx * vx + vy * vy);
    for (int q = 0; q < 9; ++q) {
        const double along = 3 * (dx[q] * vx + dy[q] * vy);
        const double equilibrium = weight[q] * density * (1 + along + 0.5 * along * along - square);
        to.f[q][cell] = from.solid[cell] ? from.f[q][cell] : f[q] + (equilibrium - f[q]) / 0.8;
    }
}

__global__ void stepAll(Lattice from, Lattice to) {
    const int cell = blockIdx.x * blockDim.x + threadIdx.x;
    if (cell < kCells)
        step(from, to, cell);
}

int main() {
    std::vector<unsigned char> solid(kCells);
    std::vector<double> start(9 * kCells), other(9 * kCells), result(9 * kCells);
    double before = 0, after = 0;
    for (int i = 0; i < kCells; ++i) {
        const int x = i % kX - 12, y = i / kX - 16;
        solid[i] = x * x + y * y < 20;
        for (int q = 0; q < 9; ++q)
            before += start[q * kCells + i] = (q ? q < 5 ? 1.0 / 9 : 1.0 / 36 : 4.0 / 9) *
                                              (1 + 0.1 * std::sin(0.3 * x + q) * std::cos(0.2 * y));
    }
    double* memory;
    unsigned char* deviceSolid;
    CUDA(cudaMalloc(&memory, 18 * kCells * sizeof(double)));
    CUDA(cudaMalloc(&deviceSolid, kCells));
    CUDA(cudaMemcpy(memory, start.data(), 9 * kCells * sizeof(double), cudaMemcpyHostToDevice));
    CUDA(cudaMemcpy(deviceSolid, solid.data(), kCells, cudaMemcpyHostToDevice));
    Lattice a, b, c, d;
    for (int q = 0; q < 9; ++q) {
        a.f[q] = memory + q * kCells;
        b.f[q] = memory + (9 + q) * kCells;
        c.f[q] = &start[q * kCells];
        d.f[q] = &other[q * kCells];
    }
    a.solid = b.solid = deviceSolid;
    c.solid = d.solid = solid.data();
    for (int i = 0; i < kSteps; ++i) {
        stepAll<<<(kCells + 63) / 64, 64>>>(a, b);
        std::swap(a, b);
        for (int cell = 0; cell < kCells; ++cell)
            step(c, d, cell);
        std::swap(c, d);
    }
    CUDA(cudaMemcpy(result.data(), a.f[0], 9 * kCells * sizeof(double), cudaMemcpyDeviceToHost));
    double worst = 0;
    for (int i = 0; i < 9 * kCells; ++i) {
        worst = std::fmax(worst, std::fabs(result[i] - c.f[i / kCells][i % kCells]));
        after += result[i];
    }
    std::printf("mass %.6f, then %.6f; largest difference %s\n", before, after,
                worst < 1e-12 ? "below 1e-12" : "too large");
    return finish(worst < 1e-12 && std::fabs(before - after) < 1e-8);
}
