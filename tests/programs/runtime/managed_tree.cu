// SPDX-License-Identifier: Apache-2.0
// Data structures that host and device share as they are: classes with operators new for managed
// memory, a list, a binary tree and strings with pointers among them. The device walks and changes
// them, also by recursion, and the host goes on.
#include "device.h"

#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

class Managed {
public:
    void* operator new(size_t bytes) {
        void* memory;
        CUDA(cudaMallocManaged(&memory, bytes));
        return memory;
    }
    void* operator new[](size_t bytes) { return operator new(bytes); }
    void operator delete(void* memory) {
        CUDA(cudaDeviceSynchronize());
        CUDA(cudaFree(memory));
    }
    void operator delete[](void* memory) { operator delete(memory); }
};

class Text : public Managed {
public:
    Text(const char* text) { assign(text, std::strlen(text)); }
    Text(const Text& other) : Managed() {
        assign(other.data_, other.size_);
    } // copies go by value to kernels
    ~Text() { CUDA(cudaFree(data_)); }
    Text& operator=(const Text&) = delete;
    __host__ __device__ size_t size() const { return size_; }
    __host__ __device__ char& operator[](size_t i) { return data_[i]; }
    __host__ __device__ const char& operator[](size_t i) const { return data_[i]; }

private:
    void assign(const char* text, size_t size) {
        size_ = size;
        CUDA(cudaMallocManaged(reinterpret_cast<void**>(&data_), size + 1));
        std::memcpy(data_, text, size);
        data_[size] = 0;
    }
    char* data_ = nullptr;
    size_t size_ = 0;
};

struct Node : Managed {
    Node(int key, const char* name) : key(key), name(name) {}
    int key, count = 0;
    Text name;
    Node *left = nullptr, *right = nullptr, *next = nullptr; // next: in a list
};

__host__ __device__ unsigned hashOf(const Text& text) {
    unsigned h = 2166136261u;
    for (size_t i = 0; i < text.size(); ++i)
        h = (h ^ (unsigned char)text[i]) * 16777619u;
    return h;
}

__device__ Node* findNode(Node* node, int key) {
    if (!node || node->key == key)
        return node;
    return findNode(key < node->key ? node->left : node->right, key);
}

__global__ void countKeys(Node* root, const int* keys, int n, int* missing) {
    for (int i = blockIdx.x * blockDim.x + threadIdx.x; i < n; i += gridDim.x * blockDim.x) {
        if (Node* node = findNode(root, keys[i]))
            atomicAdd(&node->count, 1);
        else
            atomicAdd_system(missing, 1);
    }
}

__global__ void walkList(Node* head, unsigned* hash, Text suffix) {
    unsigned all = 0;
    for (Node* node = head; node; node = node->next) {
        node->name[0] = char(node->name[0] - 'a' + 'A');
        all = all * 31 + hashOf(node->name) + hashOf(suffix);
    }
    *hash = all;
}

__global__ void reverseList(Node** head) {
    Node* done = nullptr;
    for (Node* node = *head; node;) {
        Node* rest = node->next;
        node->next = done;
        done = node;
        node = rest;
    }
    *head = done;
}

struct Shared : Managed {
    unsigned hash = 0;
    Node* head = nullptr;
};

int main() {
    constexpr int kNodes = 60, kKeys = 5000;
    std::vector<Node*> nodes;
    Shared* shared = new Shared;
    Node* root = nullptr;
    for (int i = 0; i < kNodes; ++i) {
        const int key = (i * 37) % 101;
        Node* node = new Node(key, ("name" + std::to_string(key)).c_str());
        node->next = shared->head;
        shared->head = node;
        nodes.push_back(node);
        Node** place = &root;
        while (*place)
            place = key < (*place)->key ? &(*place)->left : &(*place)->right;
        *place = node;
    }
    int *keys, *missing;
    CUDA(cudaMallocManaged(&keys, kKeys * sizeof(int)));
    CUDA(cudaMallocManaged(&missing, sizeof(int), cudaMemAttachGlobal));
    std::map<int, int> right;
    for (int i = 0; i < kKeys; ++i)
        ++right[keys[i] = int((i * 2654435761u) >> 8) % 101];
    cudaPointerAttributes about;
    CUDA(cudaPointerGetAttributes(&about, keys));
    int wrong = about.type != cudaMemoryTypeManaged;
    CUDA(cudaDeviceSetLimit(cudaLimitStackSize, 8192));
    countKeys<<<4, 64>>>(root, keys, kKeys, missing);
    CUDA(cudaDeviceSynchronize());
    int absent = 0;
    for (const auto& [key, count] : right) {
        bool isThere = false;
        for (Node* node : nodes)
            if (node->key == key) {
                wrong += node->count != count;
                isThere = true;
            }
        absent += isThere ? 0 : count;
    }
    wrong += *missing != absent || absent == 0;

    const Text suffix("!?");
    walkList<<<1, 1>>>(shared->head, &shared->hash, suffix);
    CUDA(cudaDeviceSynchronize());
    unsigned all = 0;
    for (Node* node = shared->head; node; node = node->next)
        all = all * 31 + hashOf(node->name) + hashOf(suffix);
    wrong += shared->hash != all || nodes[0]->name[0] != 'N';
    std::swap(nodes[0]->key, nodes[1]->key); // the host goes on in between
    reverseList<<<1, 1>>>(&shared->head);
    CUDA(cudaDeviceSynchronize());
    int place = 0;
    for (Node* node = shared->head; node; node = node->next)
        wrong += node != nodes[place++];
    wrong += place != kNodes;
    for (Node* node : nodes)
        delete node;
    delete shared;
    std::printf("%d wrong\n", wrong);
    return finish(wrong == 0);
}
