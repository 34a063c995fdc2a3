// SPDX-License-Identifier: Apache-2.0
// A sorting network for structs by any order, as a template with a functor and dynamic shared
// memory: small steps in one block, large ones in global memory; checked with std::sort.
#include "device.h"

#include <algorithm>
#include <cstring>
#include <vector>

struct Particle {
    float depth;
    short layer;
    unsigned char tag[2];
};
struct ByDepth {
    __host__ __device__ bool operator()(const Particle& a, const Particle& b) const {
        return a.depth != b.depth ? a.depth < b.depth : a.layer < b.layer;
    }
};
struct Descending {
    unsigned long long mask;
    __host__ __device__ bool operator()(unsigned long long a, unsigned long long b) const {
        return (a & mask) > (b & mask);
    }
};

extern __shared__ __align__(16) unsigned char sharedBytes[];

template <class T, class Less>
__device__ void exchange(T& a, T& b, bool up, Less less) {
    if (up ? less(b, a) : less(a, b)) {
        T t = a;
        a = b;
        b = t;
    }
}

template <class T, class Less>
__global__ void sortTile(T* data, int first, int last, Less less) {
    T* tile = reinterpret_cast<T*>(sharedBytes);
    const int t = threadIdx.x, base = blockIdx.x * blockDim.x * 2;
    tile[t] = data[base + t];
    tile[t + blockDim.x] = data[base + t + blockDim.x];
    for (int size = first; size <= last; size *= 2)
        for (int step = min(size / 2, int(blockDim.x)); step > 0; step /= 2) {
            __syncthreads();
            const int i = 2 * t - (t & (step - 1));
            exchange(tile[i], tile[i + step], ((base + i) & size) == 0, less);
        }
    __syncthreads();
    data[base + t] = tile[t];
    data[base + t + blockDim.x] = tile[t + blockDim.x];
}

template <class T, class Less>
__global__ void sortStep(T* data, int size, int step, Less less) {
    const int t = blockIdx.x * blockDim.x + threadIdx.x;
    const int i = 2 * t - (t & (step - 1));
    exchange(data[i], data[i + step], (i & size) == 0, less);
}

template <class T, class Less>
void sortOnDevice(std::vector<T>& values, Less less) {
    const int count = int(values.size()), threads = 128, tile = 2 * threads;
    T* data;
    CUDA(cudaMalloc(&data, count * sizeof(T)));
    CUDA(cudaMemcpy(data, values.data(), count * sizeof(T), cudaMemcpyHostToDevice));
    const size_t bytes = tile * sizeof(T);
    sortTile<<<count / tile, threads, bytes>>>(data, 2, tile, less);
    for (int size = 2 * tile; size <= count; size *= 2) {
        for (int step = size / 2; step >= tile; step /= 2)
            sortStep<<<count / tile, threads>>>(data, size, step, less);
        sortTile<<<count / tile, threads, bytes>>>(data, size, size, less);
    }
    CUDA(cudaGetLastError());
    CUDA(cudaMemcpy(values.data(), data, count * sizeof(T), cudaMemcpyDeviceToHost));
    CUDA(cudaFree(data));
}

int main() {
    std::vector<Particle> particles(1 << 12);
    std::vector<unsigned long long> keys(1 << 11);
    unsigned state = 99;
    for (Particle& p : particles) {
        state = state * 1664525u + 1013904223u;
        p = {float(int(state >> 20)) - 2000.0f, short(state >> 3), {(unsigned char)state, 7}};
    }
    for (unsigned long long& k : keys) {
        state = state * 1664525u + 1013904223u;
        k = (unsigned long long)state << 23 ^ state;
    }
    std::vector<Particle> expected = particles;
    std::vector<unsigned long long> expectedKeys = keys;
    const Descending descending = {0xffffffffffff0ull};
    std::sort(expected.begin(), expected.end(), ByDepth());
    std::sort(expectedKeys.begin(), expectedKeys.end(), descending);
    sortOnDevice(particles, ByDepth());
    sortOnDevice(keys, descending);
    int wrong = 0;
    for (size_t i = 0; i < particles.size(); ++i)
        wrong += particles[i].depth != expected[i].depth || particles[i].layer != expected[i].layer;
    for (size_t i = 0; i < keys.size(); ++i)
        wrong += (keys[i] & descending.mask) != (expectedKeys[i] & descending.mask);
    std::printf("%d wrong\n", wrong);
    return finish(wrong == 0);
}
