// SPDX-License-Identifier: Apache-2.0
// Adds vectors, and with WITH_PART calls a device function of another file.
#include <cuda_runtime.h>

#include <cstdio>
#include <vector>

#ifdef WITH_PART
extern __device__ int part(int value);
#else
static __device__ int part(int value) {
    return value + 3;
}
#endif

static __device__ int offset; // another one than that of part.cu

namespace {

template <class T>
__global__ void add(T* sum, const T* a, const T* b, int count) {
    const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
    if (i < count)
        sum[i] = a[i] + b[i] + T(part(i) + offset);
}

} // namespace

int main() {
    constexpr int kCount = 1000;
    std::vector<float> a(kCount, 1.5f), b(kCount, 2.5f), sum(kCount);
    float* memory[3];
    for (float*& pointer : memory)
        cudaMalloc(&pointer, kCount * sizeof(float));
    cudaMemcpy(memory[1], a.data(), kCount * sizeof(float), cudaMemcpyHostToDevice);
    cudaMemcpy(memory[2], b.data(), kCount * sizeof(float), cudaMemcpyHostToDevice);
    const int four = 4;
    cudaMemcpyToSymbol(offset, &four, sizeof four);
    add<<<(kCount + 127) / 128, 128>>>(memory[0], memory[1], memory[2], kCount);
    const cudaError_t error = cudaDeviceSynchronize();
    cudaMemcpy(sum.data(), memory[0], kCount * sizeof(float), cudaMemcpyDeviceToHost);
    for (int i = 0; i < kCount; ++i)
        if (sum[i] != 4.0f + float(i + 7)) {
            std::printf("%s: element %d is %g\n", cudaGetErrorString(error), i, sum[i]);
            return 1;
        }
    std::printf("%d sums are right\n", kCount);
    return 0;
}
