// SPDX-License-Identifier: Apache-2.0
// Device code beyond arithmetic: recursion, the device heap, function pointers, printf, local
// arrays, clocks.
#include <cuda_runtime.h>

#include "check.h"

__device__ __noinline__ int ackermann(int m, int n) {
    if (m == 0)
        return n + 1;
    return n == 0 ? ackermann(m - 1, 1) : ackermann(m - 1, ackermann(m, n - 1));
}

struct Node {
    int value;
    Node *left, *right;
};

__device__ Node* insert(Node* root, int value) {
    if (!root) {
        root = static_cast<Node*>(malloc(sizeof(Node)));
        root->value = value;
        root->left = root->right = nullptr;
    } else if (value < root->value) {
        root->left = insert(root->left, value);
    } else {
        root->right = insert(root->right, value);
    }
    return root;
}

__device__ int flatten(Node* root, int* out, int at) {
    if (!root)
        return at;
    at = flatten(root->left, out, at);
    out[at++] = root->value;
    at = flatten(root->right, out, at);
    free(root);
    return at;
}

__device__ int twice(int x) {
    return 2 * x;
}
__device__ int square(int x) {
    return x * x;
}
__device__ int (*const functions[2])(int) = {twice, square};

__global__ void recurse(int* out) {
    out[threadIdx.x] = ackermann(2, int(threadIdx.x));
}

__global__ void sortByTree(int* out, int n) {
    Node* root = nullptr;
    unsigned state = threadIdx.x + 1;
    for (int i = 0; i < n; ++i) {
        state = state * 1664525u + 1013904223u;
        root = insert(root, int(state >> 20));
    }
    flatten(root, out + threadIdx.x * n, 0);
}

__global__ void choose(int* out) {
    int local[16];
    for (int i = 0; i < 16; ++i)
        local[(i * 5 + int(threadIdx.x)) % 16] = i;
    out[threadIdx.x] = functions[threadIdx.x % 2](local[7]);
    const long long before = clock64();
    if (clock64() < before)
        printf("time goes backwards\n");
}

__global__ void speak(int depth) {
    if (depth > 0)
        printf("depth %d: %08x %+.2e %5s|\n", depth, depth * 0x1010101, 1.5 * depth, "ok");
}

int main() {
    int* out;
    CHECK(cudaMallocManaged(&out, 4096 * sizeof(int)));
    recurse<<<1, 8>>>(out);
    CHECK(cudaDeviceSynchronize());
    for (int i = 0; i < 8; ++i)
        std::printf("%d ", out[i]);
    const int n = 100, threads = 40;
    CHECK(cudaDeviceSetLimit(cudaLimitStackSize, 16 << 10)); // a tree may be as deep as it has nodes
    sortByTree<<<1, threads>>>(out, n);
    CHECK(cudaDeviceSynchronize());
    int wrong = 0;
    unsigned sum = 0;
    for (int i = 0; i < threads * n; ++i) {
        sum += unsigned(out[i]);
        wrong += i % n && out[i - 1] > out[i];
    }
    std::printf("\ntrees: %d out of order, sum %u\n", wrong, sum);
    choose<<<1, 16>>>(out);
    CHECK(cudaDeviceSynchronize());
    for (int i = 0; i < 16; ++i)
        std::printf("%d ", out[i]);
    std::printf("\n");
    std::fflush(stdout);
    speak<<<1, 1>>>(3);
    CHECK(cudaDeviceSynchronize());
    return 0;
}
