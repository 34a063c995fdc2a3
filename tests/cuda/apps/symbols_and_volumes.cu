// SPDX-License-Identifier: Apache-2.0
// Copies to and from variables of the program, and of boxes between pitched volumes and arrays.
#include <cuda_runtime.h>

#include "check.h"

#include <vector>

struct Settings {
    float scale;
    int offsets[3];
};
__constant__ Settings settings;
__device__ int table[8];
__device__ unsigned calls;

__global__ void use(int* out) {
    out[threadIdx.x] = int(settings.scale * table[threadIdx.x]) + settings.offsets[threadIdx.x % 3];
    atomicAdd(&calls, 1u);
    table[threadIdx.x] = -table[threadIdx.x];
}

__global__ void shade(cudaPitchedPtr volume, int width, int height) {
    const int x = threadIdx.x, y = threadIdx.y, z = blockIdx.x;
    char* slice = static_cast<char*>(volume.ptr) + volume.pitch * size_t(height) * z;
    if (x < width)
        reinterpret_cast<short*>(slice + volume.pitch * y)[x] += short(x + 10 * y + 100 * z);
}

int main() {
    const Settings host = {2.5f, {1, 20, 300}};
    const int numbers[8] = {4, 8, 12, 16, 20, 24, 28, 32};
    CHECK(cudaMemcpyToSymbol(settings, &host, sizeof host));
    CHECK(cudaMemcpyToSymbol(table, numbers, 4 * sizeof(int)));
    CHECK(cudaMemcpyToSymbol(table, numbers + 4, 4 * sizeof(int), 4 * sizeof(int)));
    int* out;
    CHECK(cudaMallocManaged(&out, 8 * sizeof(int)));
    use<<<1, 8>>>(out);
    CHECK(cudaDeviceSynchronize());
    for (int i = 0; i < 8; ++i)
        std::printf("%d ", out[i]);
    int back[8];
    unsigned count;
    CHECK(cudaMemcpyFromSymbol(back, table, sizeof back));
    CHECK(cudaMemcpyFromSymbol(&count, calls, sizeof count));
    void* address;
    size_t size;
    CHECK(cudaGetSymbolAddress(&address, table));
    CHECK(cudaGetSymbolSize(&size, table));
    int third;
    CHECK(cudaMemcpy(&third, static_cast<int*>(address) + 2, 4, cudaMemcpyDeviceToHost));
    std::printf("| %d %d, %u calls, %zu bytes, third %d\n", back[0], back[7], count, size, third);
    std::printf("beyond the symbol: %s\n",
                cudaGetErrorName(cudaMemcpyToSymbol(table, numbers, 8, 28)));
    cudaGetLastError();

    const int width = 13, height = 7, depth = 5;
    std::vector<short> volume(width * height * depth, 1000), result(volume.size());
    cudaPitchedPtr device;
    const cudaExtent bytes = make_cudaExtent(width * sizeof(short), height, depth);
    CHECK(cudaMalloc3D(&device, bytes));
    cudaMemcpy3DParms copy = {};
    copy.srcPtr = make_cudaPitchedPtr(volume.data(), width * sizeof(short), width, height);
    copy.dstPtr = device;
    copy.extent = bytes;
    copy.kind = cudaMemcpyHostToDevice;
    CHECK(cudaMemcpy3D(&copy));
    shade<<<depth, dim3(16, height)>>>(device, width, height);
    CHECK(cudaGetLastError());
    // A box of it through an array, back into the middle of the result.
    cudaArray_t array;
    const cudaChannelFormatDesc format = cudaCreateChannelDesc<short>();
    CHECK(cudaMalloc3DArray(&array, &format, make_cudaExtent(width, height, depth)));
    copy = {};
    copy.srcPtr = device;
    copy.dstArray = array;
    copy.extent = make_cudaExtent(width, height, depth);
    copy.kind = cudaMemcpyDeviceToDevice;
    CHECK(cudaMemcpy3D(&copy));
    copy = {};
    copy.srcArray = array;
    copy.srcPos = make_cudaPos(2, 1, 1);
    copy.dstPtr = make_cudaPitchedPtr(result.data(), width * sizeof(short), width, height);
    copy.dstPos = make_cudaPos(4, 2, 2);
    copy.extent = make_cudaExtent(6, 4, 3);
    copy.kind = cudaMemcpyDeviceToHost;
    CHECK(cudaMemcpy3D(&copy));
    long sum = 0;
    for (short value : result)
        sum += value;
    std::printf("corner %d, end %d, outside %d, sum %ld\n", result[(2 * height + 2) * width + 4],
                result[(4 * height + 5) * width + 9], result[0], sum);
    CHECK(cudaFreeArray(array));
    CHECK(cudaFree(device.ptr));
    return 0;
}
