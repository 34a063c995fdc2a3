// SPDX-License-Identifier: Apache-2.0
// Programs with one fault each, for the memory checker: `faults NAME`. The tests compare its
// reports with the lines marked here.
#include <cuda_runtime.h>

#include <cstdio>
#include <cstring>

__global__ void copyAll(const int* from, int* to, int count) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i <= count)      // one too many
        to[i] = from[i]; // line: off_by_one
}

__global__ void fill(int* out, int value) {
    out[threadIdx.x] = value; // line: use_after_free
}

__global__ void reverse(int* out) {
    __shared__ int tile[64];
    tile[threadIdx.x + 1] = threadIdx.x; // line: shared
    __syncthreads();
    out[threadIdx.x] = tile[63 - threadIdx.x];
}

__global__ void dynamicShared(int* out, int index) {
    extern __shared__ int values[];
    values[index] = 1; // line: dynamic
    out[0] = values[0];
}

__global__ void unaligned(char* out) {
    *reinterpret_cast<float*>(out + 2) = 1.0f; // line: misaligned
}

__device__ __align__(4) char raw[16];
__global__ void unalignedName(int* out) {
    *reinterpret_cast<int*>(raw + 1) = out[0]; // line: named
}

__global__ void fetch(cudaTextureObject_t texture, float* out) {
    out[threadIdx.x] = tex1Dfetch<float>(texture, threadIdx.x);
}

__global__ void farAway(int* out, int index) {
    out[index] = 1; // line: neighbour
}

__global__ void wide(float4* out, int index) {
    out[index] = make_float4(1, 2, 3, 4); // line: vector
}

__global__ void count(int* counter, int index) {
    atomicAdd(counter + index, 1); // line: atomic
}

__device__ int table[16];
__global__ void lookUp(int* out, int index) {
    out[0] = table[index]; // line: variable
}

__global__ void localArray(int* out, int index) {
    int scratch[8];
    for (int i = 0; i < 8; ++i)
        scratch[i] = i * out[0];
    out[0] = scratch[index]; // line: local
}

__device__ __noinline__ int follow(const int* const* link) {
    return **link; // line: host
}
__global__ void chase(const int* const* link, int* out) {
    out[0] = follow(link);
}

// Everything that is allowed, by generic pointers too.
struct Big {
    int values[32];
};
__device__ __noinline__ int sum(const int* values, int n) {
    int total = 0;
    for (int i = 0; i < n; ++i)
        total += values[i];
    return total;
}
__global__ void fine(Big big, int* out, const int* pinned, int* managed, int n) {
    __shared__ int tile[64];
    int own[16];
    for (int i = 0; i < 16; ++i)
        own[i] = i + n;
    tile[threadIdx.x] = threadIdx.x;
    __syncthreads();
    int* heap = static_cast<int*>(malloc(8 * sizeof(int)));
    for (int i = 0; i < 8; ++i)
        heap[i] = i;
    const int total = sum(tile, 64) + sum(own, 16) + sum(big.values + n, 8) + sum(heap, 8) +
                      sum(table, 16) + pinned[threadIdx.x] + sum(managed, 4);
    free(heap);
    out[threadIdx.x] = total;
}

static int run(const char* name) {
    int* a = nullptr;
    int* b = nullptr;
    cudaMalloc(&a, 100 * sizeof(int));
    cudaMalloc(&b, 100 * sizeof(int));
    cudaMemset(a, 0, 100 * sizeof(int));
    const auto is = [&](const char* which) { return std::strcmp(name, which) == 0; };
    if (is("off_by_one"))
        copyAll<<<2, 64>>>(a, b, 100);
    else if (is("use_after_free")) {
        cudaFree(a); // line: freed
        fill<<<1, 32>>>(a, 3);
        a = nullptr;
    } else if (is("shared"))
        reverse<<<1, 64>>>(a);
    else if (is("dynamic"))
        dynamicShared<<<1, 1, 64>>>(a, 16);
    else if (is("misaligned"))
        unaligned<<<1, 1>>>(reinterpret_cast<char*>(a));
    else if (is("named"))
        unalignedName<<<1, 1>>>(a);
    else if (is("texture")) {
        float* texels = nullptr;
        cudaMalloc(&texels, 32 * sizeof(float));
        cudaResourceDesc resource = {};
        resource.resType = cudaResourceTypeLinear;
        resource.res.linear.devPtr = texels;
        resource.res.linear.desc = cudaCreateChannelDesc<float>();
        resource.res.linear.sizeInBytes = 32 * sizeof(float);
        cudaTextureDesc description = {};
        cudaTextureObject_t texture = 0;
        cudaCreateTextureObject(&texture, &resource, &description, nullptr);
        fetch<<<1, 32>>>(texture, reinterpret_cast<float*>(a));
        std::printf("%s, ", cudaGetErrorName(cudaDeviceSynchronize()));
        cudaFree(texels); // line: texels
        fetch<<<1, 32>>>(texture, reinterpret_cast<float*>(a));
    } else if (is("neighbour")) // where the next allocation might be
        farAway<<<1, 1>>>(a, 300);
    else if (is("vector"))
        wide<<<1, 1>>>(reinterpret_cast<float4*>(a), 25);
    else if (is("atomic"))
        count<<<1, 1>>>(a, -1);
    else if (is("variable"))
        lookUp<<<1, 1>>>(a, 16);
    else if (is("local"))
        localArray<<<1, 1>>>(a, 9);
    else if (is("host")) {
        static int plain = 7;
        static const int* pointer = &plain;
        int** link = nullptr;
        cudaMalloc(&link, sizeof(int*));
        cudaMemcpy(link, &pointer, sizeof pointer, cudaMemcpyHostToDevice);
        chase<<<1, 1>>>(link, a);
        cudaFree(link);
    } else if (is("leak"))
        cudaMalloc(&b, 1234); // line: leak
    else {
        int *pinned = nullptr, *managed = nullptr;
        cudaMallocHost(&pinned, 64 * sizeof(int));
        cudaMallocManaged(&managed, 64 * sizeof(int));
        std::memset(pinned, 0, 64 * sizeof(int));
        std::memset(managed, 0, 64 * sizeof(int));
        fine<<<3, 64>>>(Big{}, a, pinned, managed, 3);
        cudaDeviceSynchronize();
        cudaFreeHost(pinned);
        cudaFree(managed);
    }
    const cudaError_t error = cudaDeviceSynchronize();
    std::printf("%s\n", cudaGetErrorName(error));
    cudaFree(a);
    cudaFree(b);
    return 0;
}

int main(int argc, char** argv) {
    return argc == 2 ? run(argv[1]) : 2;
}
