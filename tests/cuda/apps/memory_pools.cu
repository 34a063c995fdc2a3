// SPDX-License-Identifier: Apache-2.0
// Memory in stream order, from the device's pool and from one with a limit.
#include <cuda_runtime.h>

#include "check.h"

#include <cstdint>

__global__ void fill(int* data, int n, int value) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        data[i] = value + i;
}
__global__ void add(int* to, const int* from, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        to[i] += from[i];
}

static uint64_t valueOf(cudaMemPool_t pool, cudaMemPoolAttr attribute) {
    uint64_t value = 0;
    CHECK(cudaMemPoolGetAttribute(pool, attribute, &value));
    return value;
}

int main() {
    int device, supported;
    CHECK(cudaGetDevice(&device));
    CHECK(cudaDeviceGetAttribute(&supported, cudaDevAttrMemoryPoolsSupported, device));
    cudaStream_t stream;
    CHECK(cudaStreamCreate(&stream));
    const int n = 10000;
    int *sum, *host;
    CHECK(cudaMallocHost(&host, n * sizeof(int)));
    CHECK(cudaMallocAsync(&sum, n * sizeof(int), stream));
    CHECK(cudaMemsetAsync(sum, 0, n * sizeof(int), stream));
    for (int round = 0; round < 5; ++round) {
        int* part;
        CHECK(cudaMallocAsync(&part, n * sizeof(int), stream));
        fill<<<(n + 255) / 256, 256, 0, stream>>>(part, n, round);
        add<<<(n + 255) / 256, 256, 0, stream>>>(sum, part, n);
        CHECK(cudaFreeAsync(part, stream));
    }
    CHECK(cudaMemcpyAsync(host, sum, n * sizeof(int), cudaMemcpyDeviceToHost, stream));
    CHECK(cudaFreeAsync(sum, stream));
    CHECK(cudaStreamSynchronize(stream));
    std::printf("pools supported %d, sums %d %d\n", supported, host[0], host[n - 1]);

    cudaMemPool_t standard, current, own;
    CHECK(cudaDeviceGetDefaultMemPool(&standard, device));
    CHECK(cudaDeviceGetMemPool(&current, device));
    std::printf("the default pool is current: %d\n", standard == current);
    uint64_t threshold = uint64_t(1) << 20;
    CHECK(cudaMemPoolSetAttribute(standard, cudaMemPoolAttrReleaseThreshold, &threshold));
    std::printf("threshold %llu, used %llu\n",
                (unsigned long long)valueOf(standard, cudaMemPoolAttrReleaseThreshold),
                (unsigned long long)valueOf(standard, cudaMemPoolAttrUsedMemCurrent));

    cudaMemPoolProps properties = {};
    properties.allocType = cudaMemAllocationTypePinned;
    properties.location.type = cudaMemLocationTypeDevice;
    properties.location.id = device;
    CHECK(cudaMemPoolCreate(&own, &properties));
    void* memory;
    CHECK(cudaMallocFromPoolAsync(&memory, 1 << 20, own, stream));
    CHECK(cudaStreamSynchronize(stream));
    std::printf("own pool: used %llu, reserved enough %d\n",
                (unsigned long long)valueOf(own, cudaMemPoolAttrUsedMemCurrent),
                valueOf(own, cudaMemPoolAttrReservedMemCurrent) >= 1 << 20);
    CHECK(cudaFreeAsync(memory, stream));
    CHECK(cudaStreamSynchronize(stream));
    CHECK(cudaMemPoolTrimTo(own, 0));
    std::printf("after: used %llu, reserved %llu, high %llu\n",
                (unsigned long long)valueOf(own, cudaMemPoolAttrUsedMemCurrent),
                (unsigned long long)valueOf(own, cudaMemPoolAttrReservedMemCurrent),
                (unsigned long long)valueOf(own, cudaMemPoolAttrUsedMemHigh));
    CHECK(cudaDeviceSetMemPool(device, own));
    CHECK(cudaMallocAsync(&memory, 4096, stream));
    CHECK(cudaStreamSynchronize(stream));
    std::printf("as the device's pool: used %llu\n",
                (unsigned long long)valueOf(own, cudaMemPoolAttrUsedMemCurrent));
    CHECK(cudaFree(memory));
    CHECK(cudaDeviceSetMemPool(device, standard));
    CHECK(cudaMemPoolDestroy(own));
    std::printf("destroying the default pool: %s\n",
                cudaGetErrorName(cudaMemPoolDestroy(standard)));
    return 0;
}
