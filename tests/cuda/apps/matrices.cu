// SPDX-License-Identifier: Apache-2.0
// Matrix products of a warp through nvcuda::wmma, in several types and layouts, and through mma
// with ldmatrix. The numbers are small integers, so that every product is exact.
#include <cuda_runtime.h>
#include <mma.h>

#include "check.h"

#include <vector>

using namespace nvcuda;

constexpr int kSize = 64; // of square matrices, in elements

// Each warp computes one tile; A is row-major, B column-major.
template <class T, class Sum, int m, int n, int k, class Memory>
__global__ void multiply(const Memory* a, const Memory* b, const Sum* c, Sum* d) {
    const int row = int(blockIdx.x) * m, column = int(blockIdx.y) * n;
    wmma::fragment<wmma::matrix_a, m, n, k, T, wmma::row_major> fa;
    wmma::fragment<wmma::matrix_b, m, n, k, T, wmma::col_major> fb;
    wmma::fragment<wmma::accumulator, m, n, k, Sum> sum;
    wmma::load_matrix_sync(sum, c + row * kSize + column, kSize, wmma::mem_row_major);
    for (int i = 0; i < kSize; i += k) {
        wmma::load_matrix_sync(fa, a + row * kSize + i, kSize);
        wmma::load_matrix_sync(fb, b + column * kSize + i, kSize);
        wmma::mma_sync(sum, fa, fb, sum);
    }
    for (int i = 0; i < sum.num_elements; ++i)
        sum.x[i] = sum.x[i] + sum.x[i];
    wmma::store_matrix_sync(d + column * kSize + row, sum, kSize, wmma::mem_col_major);
}

// The same with mma.m16n8k16; A is staged in shared memory.
__global__ void multiplyByRegisters(const __half* a, const __half* b, const float* c, float* d) {
    __shared__ __align__(16) __half tile[16 * 16];
    const int row = int(blockIdx.x) * 16, column = int(blockIdx.y) * 8;
    const int lane = int(threadIdx.x), group = lane / 4, member = lane % 4;
    float sum[4];
    for (int i = 0; i < 4; ++i)
        sum[i] = c[(row + group + i / 2 * 8) * kSize + column + member * 2 + i % 2];
    for (int k = 0; k < kSize; k += 16) {
        for (int i = lane; i < 256; i += 32)
            tile[i] = a[(row + i / 16) * kSize + k + i % 16];
        __syncwarp();
        unsigned fa[4], fb[2];
        const unsigned at =
            unsigned(__cvta_generic_to_shared(tile + lane % 16 * 16 + lane / 16 * 8));
        asm volatile("ldmatrix.sync.aligned.m8n8.x4.shared.b16 {%0, %1, %2, %3}, [%4];"
                     : "=r"(fa[0]), "=r"(fa[1]), "=r"(fa[2]), "=r"(fa[3])
                     : "r"(at)
                     : "memory");
        for (int i = 0; i < 2; ++i)
            fb[i] = *reinterpret_cast<const unsigned*>(b + (column + group) * kSize + k + i * 8 +
                                                       member * 2);
        asm volatile("mma.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 {%0, %1, %2, %3}, "
                     "{%4, %5, %6, %7}, {%8, %9}, {%0, %1, %2, %3};"
                     : "+f"(sum[0]), "+f"(sum[1]), "+f"(sum[2]), "+f"(sum[3])
                     : "r"(fa[0]), "r"(fa[1]), "r"(fa[2]), "r"(fa[3]), "r"(fb[0]), "r"(fb[1]));
        __syncwarp();
    }
    for (int i = 0; i < 4; ++i)
        d[(column + member * 2 + i % 2) * kSize + row + group + i / 2 * 8] = 2 * sum[i];
}

template <class T>
T make(int value) {
    return T(float(value));
}
template <>
signed char make<signed char>(int value) {
    return static_cast<signed char>(value);
}

template <class Memory, class Sum, class Launch>
void test(const char* name, Launch launch) {
    constexpr size_t kCount = size_t(kSize) * kSize;
    std::vector<int> a(kCount), b(kCount), c(kCount);
    std::vector<Memory> hostA, hostB;
    std::vector<Sum> hostC, result(kCount);
    for (size_t i = 0; i < kCount; ++i) {
        a[i] = int(i * 7 % 11) - 5;
        b[i] = int(i * 5 % 13) - 6;
        c[i] = int(i % 17);
        hostA.push_back(make<Memory>(a[i]));
        hostB.push_back(make<Memory>(b[i]));
        hostC.push_back(Sum(float(c[i])));
    }
    Memory *deviceA, *deviceB;
    Sum *deviceC, *deviceD;
    CHECK(cudaMalloc(&deviceA, kCount * sizeof(Memory)));
    CHECK(cudaMalloc(&deviceB, kCount * sizeof(Memory)));
    CHECK(cudaMalloc(&deviceC, kCount * sizeof(Sum)));
    CHECK(cudaMalloc(&deviceD, kCount * sizeof(Sum)));
    CHECK(cudaMemcpy(deviceA, hostA.data(), kCount * sizeof(Memory), cudaMemcpyHostToDevice));
    CHECK(cudaMemcpy(deviceB, hostB.data(), kCount * sizeof(Memory), cudaMemcpyHostToDevice));
    CHECK(cudaMemcpy(deviceC, hostC.data(), kCount * sizeof(Sum), cudaMemcpyHostToDevice));
    launch(deviceA, deviceB, deviceC, deviceD);
    CHECK(cudaGetLastError());
    CHECK(cudaMemcpy(result.data(), deviceD, kCount * sizeof(Sum), cudaMemcpyDeviceToHost));
    int wrong = 0;
    double total = 0;
    for (int row = 0; row < kSize; ++row)
        for (int column = 0; column < kSize; ++column) {
            int sum = c[size_t(row * kSize + column)];
            for (int k = 0; k < kSize; ++k)
                sum += a[size_t(row * kSize + k)] * b[size_t(column * kSize + k)];
            const double got = double(float(result[size_t(column * kSize + row)]));
            wrong += got != 2.0 * sum;
            total += got * (row + 1);
        }
    std::printf("%s: %d wrong, %.0f\n", name, wrong, total);
    CHECK(cudaFree(deviceA));
    CHECK(cudaFree(deviceB));
    CHECK(cudaFree(deviceC));
    CHECK(cudaFree(deviceD));
}

#define TILES(m, n) <<<dim3(kSize / (m), kSize / (n)), 32>>>

int main() {
    test<__half, float>("halves, 16 by 16", [](auto* a, auto* b, auto* c, auto* d) {
        multiply<__half, float, 16, 16, 16> TILES(16, 16)(a, b, c, d);
    });
    test<__half, float>("halves, 8 by 32", [](auto* a, auto* b, auto* c, auto* d) {
        multiply<__half, float, 8, 32, 16> TILES(8, 32)(a, b, c, d);
    });
    test<__nv_bfloat16, float>("bfloats, 32 by 8", [](auto* a, auto* b, auto* c, auto* d) {
        multiply<__nv_bfloat16, float, 32, 8, 16> TILES(32, 8)(a, b, c, d);
    });
    test<signed char, int>("bytes", [](auto* a, auto* b, auto* c, auto* d) {
        multiply<signed char, int, 16, 16, 16> TILES(16, 16)(a, b, c, d);
    });
    test<float, float>("tf32", [](auto* a, auto* b, auto* c, auto* d) {
        multiply<wmma::precision::tf32, float, 16, 16, 8> TILES(16, 16)(a, b, c, d);
    });
    test<double, double>("doubles", [](auto* a, auto* b, auto* c, auto* d) {
        multiply<double, double, 8, 8, 4> TILES(8, 8)(a, b, c, d);
    });
    test<__half, float>("mma and ldmatrix", [](auto* a, auto* b, auto* c, auto* d) {
        multiplyByRegisters TILES(16, 8)(a, b, c, d);
    });
    return 0;
}
