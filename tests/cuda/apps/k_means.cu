// SPDX-License-Identifier: Apache-2.0
// Clusters of points by k-means: each point joins the nearest centre, atomics (in shared memory
// first) sum and count the clusters, and new centres are their means. All numbers are integers, so
// that the order of the atomics has no effect.
#include <cuda_runtime.h>

#include "check.h"
#include "clock.h"

#include <algorithm>
#include <vector>

constexpr int kClusters = 16, kDimensions = 4;

struct Sums {
    unsigned long long totals[kClusters][kDimensions];
    unsigned counts[kClusters];
    unsigned moved;
};

// Coordinate d of point i is points[d * n + i].
__global__ void assign(const int* points, int n, const int* centres, int* clusters, Sums* sums) {
    __shared__ int near[kClusters][kDimensions];
    __shared__ unsigned totals[kClusters][kDimensions], counts[kClusters], moved;
    for (int i = threadIdx.x; i < kClusters * kDimensions; i += blockDim.x) {
        (&near[0][0])[i] = centres[i];
        (&totals[0][0])[i] = 0;
        if (i < kClusters)
            counts[i] = 0;
    }
    if (threadIdx.x == 0)
        moved = 0;
    __syncthreads();
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n) {
        int best = 0, least = 0x7fffffff;
        for (int c = 0; c < kClusters; ++c) {
            int square = 0;
            for (int d = 0; d < kDimensions; ++d) {
                const int apart = points[d * n + i] - near[c][d];
                square += apart * apart;
            }
            if (square < least) {
                least = square;
                best = c;
            }
        }
        if (clusters[i] != best) {
            clusters[i] = best;
            atomicAdd(&moved, 1u);
        }
        for (int d = 0; d < kDimensions; ++d)
            atomicAdd(&totals[best][d], unsigned(points[d * n + i]));
        atomicAdd(&counts[best], 1u);
    }
    __syncthreads();
    for (int t = threadIdx.x; t < kClusters * kDimensions; t += blockDim.x)
        atomicAdd(&sums->totals[0][0] + t, (unsigned long long)((&totals[0][0])[t]));
    if (threadIdx.x < kClusters)
        atomicAdd(&sums->counts[threadIdx.x], counts[threadIdx.x]);
    if (threadIdx.x == 0)
        atomicAdd(&sums->moved, moved);
}

__global__ void move(int* centres, const Sums* sums) {
    const int c = threadIdx.x / kDimensions, d = threadIdx.x % kDimensions;
    if (sums->counts[c] != 0)
        centres[threadIdx.x] = int(sums->totals[c][d] / sums->counts[c]);
}

// One round; how many points have moved.
unsigned moveOnHost(const std::vector<int>& points, int n, std::vector<int>& centres,
                    std::vector<int>& clusters) {
    Sums sums = {};
    for (int i = 0; i < n; ++i) {
        int best = 0, least = 0x7fffffff;
        for (int c = 0; c < kClusters; ++c) {
            int square = 0;
            for (int d = 0; d < kDimensions; ++d) {
                const int apart = points[size_t(d) * n + i] - centres[c * kDimensions + d];
                square += apart * apart;
            }
            if (square < least) {
                least = square;
                best = c;
            }
        }
        sums.moved += clusters[i] != best;
        clusters[i] = best;
        ++sums.counts[best];
        for (int d = 0; d < kDimensions; ++d)
            sums.totals[best][d] += unsigned(points[size_t(d) * n + i]);
    }
    for (int c = 0; c < kClusters; ++c)
        for (int d = 0; d < kDimensions && sums.counts[c]; ++d)
            centres[c * kDimensions + d] = int(sums.totals[c][d] / sums.counts[c]);
    return sums.moved;
}

int main(int argc, char** argv) {
    Clock clock(argc, argv);
    const int n = 20000 * clock.factor() + 11, rounds = 12;
    std::vector<int> points(size_t(n) * kDimensions), first, clusters(n, -1), made(n);
    unsigned state = 99;
    const auto random = [&](unsigned below) {
        state = state * 1664525u + 1013904223u;
        return int((state >> 8) % below);
    };
    for (int i = 0; i < n; ++i)
        for (int d = 0; d < kDimensions; ++d)
            points[size_t(d) * n + i] = (i * (d + 3) * 37 % 11) * 800 + random(900) + random(900);
    for (int c = 0; c < kClusters; ++c)
        for (int d = 0; d < kDimensions; ++d)
            first.push_back(points[size_t(d) * n + c * (n / kClusters)]);

    int *devicePoints, *centres, *deviceClusters;
    Sums* sums;
    CHECK(cudaMalloc(&devicePoints, points.size() * sizeof(int)));
    CHECK(cudaMalloc(&centres, first.size() * sizeof(int)));
    CHECK(cudaMalloc(&deviceClusters, n * sizeof(int)));
    CHECK(cudaMalloc(&sums, sizeof(Sums)));
    CHECK(cudaMemcpy(devicePoints, points.data(), points.size() * sizeof(int),
                     cudaMemcpyHostToDevice));
    std::vector<unsigned> moves(rounds), expectedMoves(rounds);
    for (int time = 0; time < 2; ++time) { // the first time compiles
        CHECK(
            cudaMemcpy(centres, first.data(), first.size() * sizeof(int), cudaMemcpyHostToDevice));
        CHECK(cudaMemset(deviceClusters, 0xff, n * sizeof(int)));
        clock.start();
        for (int round = 0; round < rounds; ++round) {
            CHECK(cudaMemset(sums, 0, sizeof(Sums)));
            assign<<<(n + 255) / 256, 256>>>(devicePoints, n, centres, deviceClusters, sums);
            move<<<1, kClusters * kDimensions>>>(centres, sums);
            CHECK(
                cudaMemcpy(&moves[round], &sums->moved, sizeof(unsigned), cudaMemcpyDeviceToHost));
        }
        clock.kernels();
    }
    std::vector<int> expectedCentres = first, madeCentres(first.size());
    clock.start();
    for (int round = 0; round < rounds; ++round)
        expectedMoves[round] = moveOnHost(points, n, expectedCentres, clusters);
    clock.host("k-means");
    CHECK(cudaMemcpy(made.data(), deviceClusters, n * sizeof(int), cudaMemcpyDeviceToHost));
    CHECK(cudaMemcpy(madeCentres.data(), centres, first.size() * sizeof(int),
                     cudaMemcpyDeviceToHost));
    std::printf("clusters %s, centres %s, moves %s\n", made == clusters ? "right" : "WRONG",
                madeCentres == expectedCentres ? "right" : "WRONG",
                moves == expectedMoves ? "right" : "WRONG");
    std::printf("moved in round 1: %u, in round %d: %u; centre 5 at (%d, %d, %d, %d)\n", moves[0],
                rounds, moves[rounds - 1], madeCentres[20], madeCentres[21], madeCentres[22],
                madeCentres[23]);
    return 0;
}
