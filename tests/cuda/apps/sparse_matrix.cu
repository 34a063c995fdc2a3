// SPDX-License-Identifier: Apache-2.0
// A sparse matrix times a vector, as in solvers: a thread for each row, a warp for each row with
// shuffles, and padded rows stored by column. Values are small integers, so that the order of the
// sums has no effect.
#include <cuda_runtime.h>

#include "check.h"
#include "clock.h"

#include <vector>

// Consecutive rows: row r has the elements from starts[r] to starts[r + 1].
__global__ void rowPerThread(int rows, const int* starts, const int* columns, const float* values,
                             const float* x, float* y) {
    const int row = blockIdx.x * blockDim.x + threadIdx.x;
    if (row >= rows)
        return;
    float sum = 0;
    for (int i = starts[row]; i < starts[row + 1]; ++i)
        sum += values[i] * x[columns[i]];
    y[row] = sum;
}

__global__ void rowPerWarp(int rows, const int* starts, const int* columns, const float* values,
                           const float* x, float* y) {
    const int row = (blockIdx.x * blockDim.x + threadIdx.x) / 32, lane = threadIdx.x % 32;
    if (row >= rows)
        return;
    float sum = 0;
    for (int i = starts[row] + lane; i < starts[row + 1]; i += 32)
        sum += values[i] * x[columns[i]];
    for (int distance = 16; distance > 0; distance /= 2)
        sum += __shfl_down_sync(0xffffffffu, sum, distance);
    if (lane == 0)
        y[row] = sum;
}

// Element k of all rows, then element k + 1: lanes read neighbouring elements.
__global__ void paddedRows(int rows, int width, const int* columns, const float* values,
                           const float* x, float* y) {
    const int row = blockIdx.x * blockDim.x + threadIdx.x;
    if (row >= rows)
        return;
    float sum = 0;
    for (int k = 0; k < width; ++k) {
        const int column = columns[k * rows + row];
        if (column >= 0)
            sum += values[k * rows + row] * x[column];
    }
    y[row] = sum;
}

template <class T>
T* upload(const std::vector<T>& values) {
    T* device;
    CHECK(cudaMalloc(&device, values.size() * sizeof(T)));
    CHECK(cudaMemcpy(device, values.data(), values.size() * sizeof(T), cudaMemcpyHostToDevice));
    return device;
}

int main(int argc, char** argv) {
    Clock clock(argc, argv);
    const int rows = 5000 * clock.factor() + 7, widest = 40;
    std::vector<int> starts = {0}, columns;
    std::vector<float> values, x(rows), expected(rows), y(rows);
    unsigned state = 7;
    const auto random = [&](unsigned below) {
        state = state * 1664525u + 1013904223u;
        return (state >> 8) % below;
    };
    for (int row = 0; row < rows; ++row) {
        x[row] = float(random(15)) - 7;
        for (int i = 0, count = int(random(widest)); i < count; ++i) { // some rows are empty
            const int near = row + int(random(2001)) - 1000;
            columns.push_back(i % 4 == 0     ? int(random(unsigned(rows)))
                              : near < 0     ? 0
                              : near >= rows ? rows - 1
                                             : near);
            values.push_back(float(random(31)) - 15);
        }
        starts.push_back(int(columns.size()));
    }
    std::vector<int> paddedColumns(size_t(rows) * widest, -1);
    std::vector<float> paddedValues(paddedColumns.size());
    for (int row = 0; row < rows; ++row)
        for (int i = starts[row]; i < starts[row + 1]; ++i) {
            paddedColumns[size_t(i - starts[row]) * rows + row] = columns[i];
            paddedValues[size_t(i - starts[row]) * rows + row] = values[i];
        }
    int *deviceStarts = upload(starts), *deviceColumns = upload(columns);
    int* devicePaddedColumns = upload(paddedColumns);
    float *deviceValues = upload(values), *deviceX = upload(x), *deviceY = upload(y);
    float* devicePaddedValues = upload(paddedValues);

    const char* names[] = {"a thread for a row", "a warp for a row", "padded rows"};
    for (int way = 0; way < 3; ++way)
        for (int round = 0; round < 2; ++round) { // the first one compiles
            clock.start();
            if (way == 0)
                rowPerThread<<<(rows + 255) / 256, 256>>>(rows, deviceStarts, deviceColumns,
                                                          deviceValues, deviceX, deviceY);
            else if (way == 1)
                rowPerWarp<<<(rows + 3) / 4, 128>>>(rows, deviceStarts, deviceColumns, deviceValues,
                                                    deviceX, deviceY);
            else
                paddedRows<<<(rows + 255) / 256, 256>>>(rows, widest, devicePaddedColumns,
                                                        devicePaddedValues, deviceX, deviceY);
            CHECK(cudaDeviceSynchronize());
            clock.kernels();
            if (round == 0)
                continue;
            CHECK(cudaMemcpy(y.data(), deviceY, rows * sizeof(float), cudaMemcpyDeviceToHost));
            clock.start();
            for (int row = 0; row < rows; ++row) {
                float sum = 0;
                for (int i = starts[row]; i < starts[row + 1]; ++i)
                    sum += values[i] * x[columns[i]];
                expected[row] = sum;
            }
            clock.host(names[way]);
            int wrong = 0;
            double sum = 0;
            for (int row = 0; row < rows; ++row) {
                wrong += y[row] != expected[row];
                sum += double(y[row]) * (row % 7);
            }
            std::printf("%s: %d of %d wrong, sum %.0f\n", names[way], wrong, rows, sum);
        }
    return 0;
}
