// SPDX-License-Identifier: Apache-2.0
// A solver in one cooperative kernel: conjugate gradients whose blocks meet at barriers of the
// whole grid, with sums by warps. The matrix is in two formats, rows one after another and columns
// of equal length; both must give the known solution.
#include "device.h"

#include <cooperative_groups.h>

#include <cmath>
#include <vector>

namespace cg = cooperative_groups;

struct Csr {
    const int *begin, *column;
    const double* value;
    __device__ double row(int i, const double* x) const {
        double sum = 0;
        for (int k = begin[i]; k < begin[i + 1]; ++k)
            sum += value[k] * x[column[k]];
        return sum;
    }
};
struct Ell {
    const int* column;
    const double* value;
    int width, rows;
    __device__ double row(int i, const double* x) const {
        double sum = 0;
        for (int k = 0; k < width; ++k)
            if (const int c = column[k * rows + i]; c >= 0)
                sum += value[k * rows + i] * x[c];
        return sum;
    }
};

struct Vectors {
    double *x, *r, *p, *q;
    double* sums; // three
    int* iterations;
};

__device__ void addToSum(double value, double* sum, const cg::thread_block& block) {
    __shared__ double parts[32];
    const auto warp = cg::tiled_partition<32>(block);
    for (int step = 16; step > 0; step /= 2)
        value += warp.shfl_down(value, step);
    if (warp.thread_rank() == 0)
        parts[threadIdx.x / 32] = value;
    block.sync();
    if (threadIdx.x == 0) {
        double all = 0;
        for (unsigned i = 0; i < blockDim.x / 32; ++i)
            all += parts[i];
        atomicAdd(sum, all);
    }
    block.sync();
}

template <class Matrix>
__global__ void solve(Matrix a, const double* b, Vectors v, int n, double limit, int most) {
    const cg::grid_group grid = cg::this_grid();
    const cg::thread_block block = cg::this_thread_block();
    const int first = int(grid.thread_rank()), step = int(grid.size());
    double local = 0;
    for (int i = first; i < n; i += step) {
        v.x[i] = 0;
        v.r[i] = v.p[i] = b[i];
        local += b[i] * b[i];
    }
    addToSum(local, &v.sums[0], block);
    grid.sync();
    double rr = v.sums[0];
    int k = 0;
    for (; k < most && rr > limit; ++k) {
        local = 0;
        for (int i = first; i < n; i += step) {
            v.q[i] = a.row(i, v.p);
            local += v.p[i] * v.q[i];
        }
        addToSum(local, &v.sums[1], block);
        grid.sync();
        const double alpha = rr / v.sums[1];
        local = 0;
        for (int i = first; i < n; i += step) {
            v.x[i] += alpha * v.p[i];
            v.r[i] -= alpha * v.q[i];
            local += v.r[i] * v.r[i];
        }
        addToSum(local, &v.sums[2], block);
        grid.sync();
        const double next = v.sums[2], beta = next / rr;
        for (int i = first; i < n; i += step)
            v.p[i] = v.r[i] + beta * v.p[i];
        rr = next;
        grid.sync();
        if (grid.thread_rank() == 0)
            v.sums[1] = v.sums[2] = 0;
        grid.sync();
    }
    if (grid.thread_rank() == 0)
        *v.iterations = k;
}

template <class T>
T* toDevice(const std::vector<T>& values) {
    T* memory = nullptr;
    CUDA(cudaMalloc(&memory, values.size() * sizeof(T)));
    CUDA(cudaMemcpy(memory, values.data(), values.size() * sizeof(T), cudaMemcpyHostToDevice));
    return memory;
}

template <class Matrix>
double errorOf(Matrix matrix, const double* b, const std::vector<double>& solution,
               int* iterations) {
    int n = int(solution.size()), blocks = 0, processors = 0;
    Vectors v;
    for (double** vector : {&v.x, &v.r, &v.p, &v.q})
        CUDA(cudaMalloc(vector, n * sizeof(double)));
    CUDA(cudaMalloc(&v.sums, 3 * sizeof(double)));
    CUDA(cudaMemset(v.sums, 0, 3 * sizeof(double)));
    CUDA(cudaMallocManaged(&v.iterations, sizeof(int)));
    CUDA(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, solve<Matrix>, 64, 0));
    CUDA(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, 0));
    double limit = 1e-18;
    int most = 500;
    void* arguments[] = {&matrix, &b, &v, &n, &limit, &most};
    const int grid = blocks * processors < 4 ? blocks * processors : 4;
    CUDA(cudaLaunchCooperativeKernel(reinterpret_cast<void*>(solve<Matrix>), dim3(grid), dim3(64),
                                     arguments, 0, 0));
    std::vector<double> x(n);
    CUDA(cudaMemcpy(x.data(), v.x, n * sizeof(double), cudaMemcpyDeviceToHost));
    *iterations = *v.iterations;
    double largest = 0;
    for (int i = 0; i < n; ++i)
        largest = std::fmax(largest, std::fabs(x[i] - solution[i]));
    return largest;
}

int main() {
    constexpr int kSide = 12, n = kSide * kSide, kWidth = 5;
    std::vector<int> begin = {0}, column, ellColumn(kWidth * n, -1);
    std::vector<double> value, ellValue(kWidth * n, 0), solution(n), b(n);
    for (int i = 0; i < n; ++i) {
        const int x = i % kSide, y = i / kSide;
        const auto add = [&](int c, double a) {
            const int k = int(column.size()) - begin.back();
            column.push_back(c);
            value.push_back(a);
            ellColumn[k * n + i] = c;
            ellValue[k * n + i] = a;
        };
        if (y > 0)
            add(i - kSide, -1);
        if (x > 0)
            add(i - 1, -1);
        add(i, 4.1);
        if (x + 1 < kSide)
            add(i + 1, -1);
        if (y + 1 < kSide)
            add(i + kSide, -1);
        begin.push_back(int(column.size()));
        solution[i] = std::sin(0.3 * x) + 0.01 * y * y;
    }
    for (int i = 0; i < n; ++i)
        for (int k = begin[i]; k < begin[i + 1]; ++k)
            b[i] += value[k] * solution[column[k]];
    const double* rhs = toDevice(b);
    int iterations[2];
    const double rows = errorOf(Csr{toDevice(begin), toDevice(column), toDevice(value)}, rhs,
                                solution, &iterations[0]);
    const double columns = errorOf(Ell{toDevice(ellColumn), toDevice(ellValue), kWidth, n}, rhs,
                                   solution, &iterations[1]);
    const bool right = rows < 1e-8 && columns < 1e-8 && iterations[0] > 10 && iterations[0] < 100 &&
                       std::abs(iterations[0] - iterations[1]) <= 1;
    std::printf("errors %.1e, %.1e after %d and %d iterations\n", rows, columns, iterations[0],
                iterations[1]);
    return finish(right);
}
