// SPDX-License-Identifier: Apache-2.0
// A cryptography library: 256-bit products by inline PTX with carry chains, scoped registers and
// predicates in the text; each product is checked against 32-bit steps on the host.
#include "device.h"

#include <vector>

struct Number {
    unsigned w[8];
};

__device__ void multiply(const Number& a, const Number& b, unsigned r[16]) {
    for (int i = 0; i < 16; ++i)
        r[i] = 0;
#pragma unroll
    for (int i = 0; i < 8; ++i) {
        unsigned carry;
        asm("mad.lo.cc.u32 %0, %1, %2, %0;" : "+r"(r[i]) : "r"(a.w[0]), "r"(b.w[i]));
#pragma unroll
        for (int j = 1; j < 8; ++j)
            asm volatile("madc.lo.cc.u32 %0, %1, %2, %0;"
                         : "+r"(r[i + j])
                         : "r"(a.w[j]), "r"(b.w[i]));
        asm volatile("addc.u32 %0, 0, 0;" : "=r"(carry));
        asm volatile("mad.hi.cc.u32 %0, %1, %2, %0;" : "+r"(r[i + 1]) : "r"(a.w[0]), "r"(b.w[i]));
#pragma unroll
        for (int j = 1; j < 7; ++j)
            asm volatile("madc.hi.cc.u32 %0, %1, %2, %0;"
                         : "+r"(r[i + j + 1])
                         : "r"(a.w[j]), "r"(b.w[i]));
        asm volatile("madc.hi.u32 %0, %1, %2, %3;"
                     : "=r"(r[i + 8])
                     : "r"(a.w[7]), "r"(b.w[i]), "r"(carry));
    }
}

// Bytes turned around, a select by predicate, a logic table.
__device__ unsigned digest(const unsigned r[16]) {
    unsigned h = 0x9e3779b9u;
    for (int i = 0; i < 16; ++i)
        asm("{\n\t.reg .pred odd;\n\t.reg .b32 t, one;\n\tand.b32 one, %1, 1;\n\t"
            "setp.ne.u32 odd, one, 0;\n\tprmt.b32 t, %1, 0, 0x0123;\n\t"
            "@odd lop3.b32 %0, %0, t, %1, 0x96;\n\t@!odd add.u32 %0, %0, t;\n\t"
            "shf.l.wrap.b32 %0, %0, %0, 5;\n\t}"
            : "+r"(h)
            : "r"(r[i]));
    return h;
}

__global__ void products(const Number* numbers, unsigned* out, unsigned* digests, int count) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= count)
        return;
    unsigned r[16];
    multiply(numbers[i], numbers[count - 1 - i], r);
    for (int j = 0; j < 16; ++j)
        out[j * count + i] = r[j];
    digests[i] = digest(r);
}

int main() {
    const int count = 300;
    std::vector<Number> numbers(count);
    unsigned state = 3;
    for (int i = 0; i < count; ++i)
        for (unsigned& w : numbers[i].w) {
            state = state * 1664525u + 1013904223u;
            w = i % 5 == 0 ? 0xffffffffu : i % 7 == 0 ? 0u : state ^ state >> 13;
        }
    Number* in;
    unsigned *out, *digests;
    std::vector<unsigned> result(16 * count), hashes(count);
    CUDA(cudaMalloc(&in, count * sizeof(Number)));
    CUDA(cudaMalloc(&out, result.size() * sizeof(unsigned)));
    CUDA(cudaMalloc(&digests, count * sizeof(unsigned)));
    CUDA(cudaMemcpy(in, numbers.data(), count * sizeof(Number), cudaMemcpyHostToDevice));
    products<<<(count + 95) / 96, 96>>>(in, out, digests, count);
    CUDA(cudaMemcpy(result.data(), out, result.size() * sizeof(unsigned), cudaMemcpyDeviceToHost));
    CUDA(cudaMemcpy(hashes.data(), digests, count * sizeof(unsigned), cudaMemcpyDeviceToHost));
    int wrong = 0;
    for (int n = 0; n < count; ++n) {
        unsigned r[16] = {}, h = 0x9e3779b9u;
        for (int i = 0; i < 8; ++i) {
            unsigned long long carry = 0;
            for (int j = 0; j < 8; ++j) {
                carry +=
                    (unsigned long long)numbers[n].w[j] * numbers[count - 1 - n].w[i] + r[i + j];
                r[i + j] = unsigned(carry);
                carry >>= 32;
            }
            r[i + 8] = unsigned(carry);
        }
        for (int i = 0; i < 16; ++i) {
            wrong += r[i] != result[i * count + n];
            const unsigned t = __builtin_bswap32(r[i]);
            h = r[i] & 1 ? h ^ t ^ r[i] : h + t;
            h = h << 5 | h >> 27;
        }
        wrong += h != hashes[n];
    }
    std::printf("%d wrong\n", wrong);
    return finish(wrong == 0);
}
