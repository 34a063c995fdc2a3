// SPDX-License-Identifier: Apache-2.0
// Managed memory: host and kernel take turns on one list of structs.
#include <cuda_runtime.h>

#include "check.h"

struct Node {
    int value;
    Node* next;
};

__global__ void doubleAll(Node* head) {
    for (Node* n = head; n; n = n->next)
        n->value *= 2;
}

int main() {
    Node* nodes;
    CHECK(cudaMallocManaged(&nodes, 5 * sizeof(Node)));
    for (int i = 0; i < 5; ++i)
        nodes[i] = {i + 1, i < 4 ? &nodes[i + 1] : nullptr};
    doubleAll<<<1, 1>>>(nodes);
    CHECK(cudaDeviceSynchronize());
    nodes[0].value += 100;
    doubleAll<<<1, 1>>>(nodes);
    CHECK(cudaDeviceSynchronize());
    for (int i = 0; i < 5; ++i)
        std::printf("%d ", nodes[i].value);
    cudaPointerAttributes attributes;
    CHECK(cudaPointerGetAttributes(&attributes, nodes));
    std::printf("type %d\n", int(attributes.type));
    CHECK(cudaFree(nodes));
    return 0;
}
