// SPDX-License-Identifier: Apache-2.0
// A database join on an open-addressing hash table: threads claim slots by atomicCAS on 64-bit
// words, erase with tombstones and probe with other keys; checked against std::unordered_map.
#include "device.h"

#include <unordered_map>
#include <vector>

typedef unsigned long long Slot; // key in the upper half, value in the lower
static const Slot kEmpty = ~0ull;
static const unsigned kDeleted = 0xfffffffeu;

struct Table {
    Slot* slots;
    unsigned mask;
    unsigned* used;
};

__host__ __device__ inline unsigned mix(unsigned k) {
    k ^= k >> 16;
    k *= 0x85ebca6bu;
    k ^= k >> 13;
    k *= 0xc2b2ae35u;
    return k ^ (k >> 16);
}

__global__ void clear(Table t) {
    for (unsigned i = blockIdx.x * blockDim.x + threadIdx.x; i <= t.mask;
         i += gridDim.x * blockDim.x)
        t.slots[i] = kEmpty;
}

// Values of one key are added up.
__global__ void insert(Table t, const uint2* rows, unsigned count) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count)
        return;
    const uint2 row = rows[i];
    unsigned at = mix(row.x) & t.mask;
    while (true) {
        Slot old = atomicCAS(&t.slots[at], kEmpty, Slot(row.x) << 32 | row.y);
        if (old == kEmpty) {
            atomicInc(t.used, 0xffffffffu);
            return;
        }
        if (unsigned(old >> 32) == row.x) {
            Slot seen;
            do {
                seen = old;
                old = atomicCAS(&t.slots[at], seen, Slot(row.x) << 32 | (unsigned(seen) + row.y));
            } while (old != seen);
            return;
        }
        at = (at + 1) & t.mask;
    }
}

__global__ void erase(Table t, unsigned divisor) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i > t.mask)
        return;
    const Slot s = t.slots[i];
    if (s != kEmpty && unsigned(s >> 32) % divisor == 0) {
        atomicExch(&t.slots[i], Slot(kDeleted) << 32);
        atomicSub(t.used, 1u);
    }
}

__global__ void probe(Table t, const unsigned* keys, unsigned* found, unsigned count) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count)
        return;
    unsigned at = mix(keys[i]) & t.mask;
    unsigned result = 0xffffffffu;
    for (Slot s; (s = __ldg(&t.slots[at])) != kEmpty; at = (at + 1) & t.mask)
        if (unsigned(s >> 32) == keys[i]) {
            result = unsigned(s);
            break;
        }
    found[i] = result;
}

int main() {
    const unsigned count = 20000, capacity = 1u << 15, queries = 10000;
    std::vector<uint2> rows(count);
    std::unordered_map<unsigned, unsigned> reference;
    for (unsigned i = 0; i < count; ++i) {
        rows[i] = make_uint2(mix(i) % 15000, i % 97);
        reference[rows[i].x] += rows[i].y;
    }
    for (auto i = reference.begin(); i != reference.end();)
        i = i->first % 7 == 0 ? reference.erase(i) : std::next(i);
    std::vector<unsigned> keys(queries), found(queries);
    for (unsigned i = 0; i < queries; ++i)
        keys[i] = i * 2;

    Table t = {nullptr, capacity - 1, nullptr};
    uint2* deviceRows;
    unsigned *deviceKeys, *deviceFound;
    CUDA(cudaMalloc(&t.slots, capacity * sizeof(Slot)));
    CUDA(cudaMalloc(&t.used, sizeof(unsigned)));
    CUDA(cudaMemset(t.used, 0, sizeof(unsigned)));
    CUDA(cudaMalloc(&deviceRows, count * sizeof(uint2)));
    CUDA(cudaMalloc(&deviceKeys, queries * sizeof(unsigned)));
    CUDA(cudaMalloc(&deviceFound, queries * sizeof(unsigned)));
    CUDA(cudaMemcpy(deviceRows, rows.data(), count * sizeof(uint2), cudaMemcpyHostToDevice));
    CUDA(cudaMemcpy(deviceKeys, keys.data(), queries * sizeof(unsigned), cudaMemcpyHostToDevice));
    clear<<<16, 256>>>(t);
    insert<<<(count + 191) / 192, 192>>>(t, deviceRows, count);
    erase<<<capacity / 128, 128>>>(t, 7);
    probe<<<(queries + 255) / 256, 256>>>(t, deviceKeys, deviceFound, queries);
    CUDA(cudaGetLastError());
    unsigned used;
    CUDA(cudaMemcpy(&used, t.used, sizeof(used), cudaMemcpyDeviceToHost));
    CUDA(cudaMemcpy(found.data(), deviceFound, queries * sizeof(unsigned), cudaMemcpyDeviceToHost));
    int wrong = used != reference.size();
    for (unsigned i = 0; i < queries; ++i) {
        const auto at = reference.find(keys[i]);
        wrong += found[i] != (at == reference.end() ? 0xffffffffu : at->second);
    }
    std::printf("%u keys, %d wrong\n", used, wrong);
    CUDA(cudaDeviceReset());
    return finish(wrong == 0);
}
