// SPDX-License-Identifier: Apache-2.0
// Integers of 128 bits: nvcc divides them by chains of add and subtract instructions that share one
// carry flag.
#include "check.h"

#include <cstdint>
#include <cstring>
#include <vector>

using Wide = unsigned __int128;

struct Case {
    uint64_t highA, lowA, highB, lowB;
};
struct Result {
    uint64_t word[10];
};

__host__ __device__ void put(Result& to, int at, Wide value) {
    to.word[at] = uint64_t(value);
    to.word[at + 1] = uint64_t(value >> 64);
}

__host__ __device__ Result calculate(const Case& from) {
    const Wide a = Wide(from.highA) << 64 | from.lowA, b = Wide(from.highB) << 64 | from.lowB;
    Result to;
    put(to, 0, a / b);
    put(to, 2, a % b);
    put(to, 4, a - b);
    put(to, 6, a * b + a);
    const __int128 lessA = __int128(a >> 1), lessB = -__int128((b >> 2) + 1);
    put(to, 8, Wide(lessA / lessB) ^ Wide(lessA % lessB));
    return to;
}

__global__ void calculateAll(const Case* cases, Result* results, int count) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < count)
        results[i] = calculate(cases[i]);
}

int main() {
    uint64_t state = 1;
    const auto random = [&] {
        state = state * 6364136223846793005u + 1442695040888963407u;
        return state ^ state >> 29;
    };
    std::vector<Case> cases = {{0, 7, 0, 1000003}, {0, 1000, 0, 7}, {1, 0, 0, 3}, {5, 0, 5, 0}};
    for (int i = 0; i < 2000; ++i) {
        Case made = {random() >> random() % 64, random(), random() >> random() % 64, random()};
        if (i % 3 == 0)
            made.highB = 0;
        if (i % 5 == 0)
            made.highA = 0;
        made.lowB |= 1;
        cases.push_back(made);
    }
    const int count = int(cases.size());
    Case* in;
    Result* out;
    CHECK(cudaMallocManaged(&in, sizeof(Case) * count));
    CHECK(cudaMallocManaged(&out, sizeof(Result) * count));
    std::memcpy(in, cases.data(), sizeof(Case) * count);
    calculateAll<<<(count + 63) / 64, 64>>>(in, out, count);
    CHECK(cudaDeviceSynchronize());
    int wrong = 0;
    for (int i = 0; i < count; ++i) {
        const Result expected = calculate(cases[i]);
        wrong += std::memcmp(&expected, &out[i], sizeof expected) != 0;
    }
    std::printf("%d cases, %d wrong\n", count, wrong);
    CHECK(cudaFree(in));
    CHECK(cudaFree(out));
    return 0;
}
