// SPDX-License-Identifier: Apache-2.0
// Fourier transforms of 1024 points, one in each block: steps of radix 2 in shared memory with a
// barrier after each, and steps of radix 4 with tables of roots. The inverse transform restores the
// input.
#include <cuda_runtime.h>

#include "check.h"
#include "clock.h"

#include <cmath>
#include <complex>
#include <vector>

constexpr int kPoints = 1024, kBits = 10;

// A thread for each pair.
__global__ void radix2(const float2* in, float2* out, float sign) {
    __shared__ float2 points[kPoints];
    const float2* from = in + size_t(blockIdx.x) * kPoints;
    float2* to = out + size_t(blockIdx.x) * kPoints;
    for (int i = threadIdx.x; i < kPoints; i += blockDim.x)
        points[__brev(i) >> (32 - kBits)] = from[i];
    __syncthreads();
    for (int half = 1; half < kPoints; half *= 2) {
        const int k = threadIdx.x % half, first = (threadIdx.x - k) * 2 + k;
        float s, c;
        sincospif(sign * float(k) / float(half), &s, &c);
        const float2 a = points[first], b = points[first + half];
        const float2 turned = {b.x * c - b.y * s, b.x * s + b.y * c};
        points[first] = {a.x + turned.x, a.y + turned.y};
        points[first + half] = {a.x - turned.x, a.y - turned.y};
        __syncthreads();
    }
    for (int i = threadIdx.x; i < kPoints; i += blockDim.x)
        to[i] = points[i];
}

__device__ float2 times(float2 a, float2 b) {
    return {a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x};
}
__device__ float2 plus(float2 a, float2 b) {
    return {a.x + b.x, a.y + b.y};
}
__device__ float2 minus(float2 a, float2 b) {
    return {a.x - b.x, a.y - b.y};
}

// A thread for every four points, which go through two arrays in turn and end in order (Stockham).
__global__ void radix4(const float2* in, float2* out, const float2* roots, float sign) {
    __shared__ float2 arrays[2][kPoints];
    const size_t offset = size_t(blockIdx.x) * kPoints;
    const int t = threadIdx.x, quarter = kPoints / 4;
    for (int k = 0; k < 4; ++k)
        arrays[0][t + k * quarter] = in[offset + t + k * quarter];
    __syncthreads();
    int now = 0;
    for (int step = 1; step < kPoints; step *= 4, now ^= 1) {
        const int k = t % step;
        float2 v[4];
        for (int i = 0; i < 4; ++i) {
            float2 root = roots[k * i * (kPoints / (4 * step))];
            root.y *= sign;
            v[i] = times(arrays[now][t + i * quarter], root);
        }
        const float2 a = plus(v[0], v[2]), b = minus(v[0], v[2]), c = plus(v[1], v[3]);
        const float2 d = minus(v[1], v[3]), turned = {sign * d.y, -sign * d.x};
        const int to = (t - k) * 4 + k;
        arrays[now ^ 1][to] = plus(a, c);
        arrays[now ^ 1][to + step] = plus(b, turned);
        arrays[now ^ 1][to + 2 * step] = minus(a, c);
        arrays[now ^ 1][to + 3 * step] = minus(b, turned);
        __syncthreads();
    }
    for (int i = 0; i < 4; ++i)
        out[offset + t + i * quarter] = arrays[now][t + i * quarter];
}

void transform(const std::vector<std::complex<float>>& roots, const std::complex<float>* in,
               std::complex<float>* out) {
    for (int i = 0; i < kPoints; ++i) {
        unsigned to = 0;
        for (int bit = 0; bit < kBits; ++bit)
            to |= (i >> bit & 1u) << (kBits - 1 - bit);
        out[to] = in[i];
    }
    for (int half = 1; half < kPoints; half *= 2)
        for (int first = 0; first < kPoints; first += 2 * half)
            for (int k = 0; k < half; ++k) {
                const std::complex<float> a = out[first + k], r = roots[k * (kPoints / 2 / half)];
                const std::complex<float> b = out[first + k + half];
                const std::complex<float> turned = {b.real() * r.real() - b.imag() * r.imag(),
                                                    b.real() * r.imag() + b.imag() * r.real()};
                out[first + k] = a + turned;
                out[first + k + half] = a - turned;
            }
}

int main(int argc, char** argv) {
    Clock clock(argc, argv);
    const int count = 24 * clock.factor();
    const size_t all = size_t(count) * kPoints;
    std::vector<std::complex<float>> signal(all), expected(all), made(all), roots(kPoints);
    for (size_t i = 0; i < all; ++i)
        signal[i] = {float(i * 7919 % 1009) / 1009 - 0.5f, float(i * 104729 % 997) / 997 - 0.5f};
    for (int i = 0; i < kPoints; ++i)
        roots[i] = std::complex<float>(std::polar(1.0, -2 * M_PI * i / kPoints));
    float2 *in, *out, *back, *table;
    CHECK(cudaMalloc(&in, all * sizeof(float2)));
    CHECK(cudaMalloc(&out, all * sizeof(float2)));
    CHECK(cudaMalloc(&back, all * sizeof(float2)));
    CHECK(cudaMalloc(&table, kPoints * sizeof(float2)));
    CHECK(cudaMemcpy(in, signal.data(), all * sizeof(float2), cudaMemcpyHostToDevice));
    CHECK(cudaMemcpy(table, roots.data(), kPoints * sizeof(float2), cudaMemcpyHostToDevice));
    for (int radix = 2; radix <= 4; radix += 2) {
        for (int round = 0; round < 2; ++round) { // the first one compiles
            clock.start();
            if (radix == 2)
                radix2<<<count, kPoints / 2>>>(in, out, -1);
            else
                radix4<<<count, kPoints / 4>>>(in, out, table, 1);
            CHECK(cudaDeviceSynchronize());
            clock.kernels();
        }
        clock.start();
        for (int i = 0; i < count; ++i)
            transform(roots, &signal[size_t(i) * kPoints], &expected[size_t(i) * kPoints]);
        clock.host(radix == 2 ? "radix 2" : "radix 4");
        CHECK(cudaMemcpy(made.data(), out, all * sizeof(float2), cudaMemcpyDeviceToHost));
        double error = 0, size = 0;
        for (size_t i = 0; i < all; ++i) {
            error = std::fmax(error, std::abs(made[i] - expected[i]));
            size = std::fmax(size, std::abs(expected[i]));
        }
        if (radix == 2)
            radix2<<<count, kPoints / 2>>>(out, back, 1);
        else
            radix4<<<count, kPoints / 4>>>(out, back, table, -1);
        CHECK(cudaMemcpy(made.data(), back, all * sizeof(float2), cudaMemcpyDeviceToHost));
        double apart = 0;
        for (size_t i = 0; i < all; ++i)
            apart = std::fmax(apart, std::abs(made[i] / float(kPoints) - signal[i]));
        std::printf("radix %d: spectrum %s, signal back %s\n", radix,
                    error < 2e-6 * size ? "right" : "WRONG", apart < 1e-6 ? "right" : "WRONG");
    }
    return 0;
}
