// SPDX-License-Identifier: Apache-2.0
// A miner: hashes blocks twice with SHA-256 (table in __constant__ memory, rotations, 16-word
// schedule in registers) and searches for a nonce by atomicMin; the host has the same function, and
// one digest is that of the standard.
#include "device.h"

#include <cstring>

#define TABLE                                                                                      \
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4,            \
        0xab1c5ed5, 0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe,        \
        0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f,        \
        0x4a7484aa, 0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7,        \
        0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967, 0x27b70a85, 0x2e1b2138, 0x4d2c6dfc,        \
        0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85, 0xa2bfe8a1, 0xa81a664b,        \
        0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116,        \
        0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,        \
        0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7,        \
        0xc67178f2
__constant__ unsigned deviceTable[64] = {TABLE};
#ifndef __CUDA_ARCH__
static const unsigned hostTable[64] = {TABLE};
#endif

__host__ __device__ inline unsigned turn(unsigned x, unsigned n) {
#ifdef __CUDA_ARCH__
    return __funnelshift_r(x, x, n);
#else
    return x >> n | x << (32 - n);
#endif
}

__host__ __device__ inline void compress(unsigned state[8], const unsigned block[16]) {
#ifdef __CUDA_ARCH__
    const unsigned* table = deviceTable;
#else
    const unsigned* table = hostTable;
#endif
    unsigned w[16], a = state[0], b = state[1], c = state[2], d = state[3], e = state[4],
                    f = state[5], g = state[6], h = state[7];
#pragma unroll
    for (int i = 0; i < 64; ++i) {
        if (i < 16)
            w[i] = block[i];
        else {
            const unsigned x = w[(i + 1) & 15], y = w[(i + 14) & 15];
            w[i & 15] += (turn(x, 7) ^ turn(x, 18) ^ x >> 3) + w[(i + 9) & 15] +
                         (turn(y, 17) ^ turn(y, 19) ^ y >> 10);
        }
        const unsigned t = h + (turn(e, 6) ^ turn(e, 11) ^ turn(e, 25)) + (g ^ (e & (f ^ g))) +
                           table[i] + w[i & 15];
        const unsigned u = (turn(a, 2) ^ turn(a, 13) ^ turn(a, 22)) + ((a & b) | (c & (a | b)));
        h = g, g = f, f = e, e = d + t, d = c, c = b, b = a, a = t + u;
    }
    state[0] += a, state[1] += b, state[2] += c, state[3] += d;
    state[4] += e, state[5] += f, state[6] += g, state[7] += h;
}

__host__ __device__ inline void start(unsigned s[8]) {
    s[0] = 0x6a09e667, s[1] = 0xbb67ae85, s[2] = 0x3c6ef372, s[3] = 0xa54ff53a;
    s[4] = 0x510e527f, s[5] = 0x9b05688c, s[6] = 0x1f83d9ab, s[7] = 0x5be0cd19;
}

// Twice over 12 bytes: a header of eight and the nonce.
__host__ __device__ inline void hashTwice(unsigned a, unsigned b, unsigned nonce, unsigned out[8]) {
    unsigned block[16] = {a, b, nonce, 0x80000000u, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 96};
    unsigned first[8];
    start(first);
    compress(first, block);
    for (int i = 0; i < 8; ++i)
        block[i] = first[i];
    block[8] = 0x80000000u;
    block[15] = 256;
    start(out);
    compress(out, block);
}

__global__ void mine(unsigned a, unsigned b, unsigned limit, unsigned* best, unsigned* digests) {
    const unsigned nonce = blockIdx.x * blockDim.x + threadIdx.x;
    unsigned digest[8];
    hashTwice(a, b, nonce, digest);
    digests[nonce] = digest[0] ^ digest[7];
    if (digest[0] < limit)
        atomicMin(best, nonce);
}

int main() {
    const unsigned kNonces = 8192, limit = 0x00200000;
    unsigned abc[8], block[16] = {0x61626380};
    block[15] = 24;
    start(abc);
    compress(abc, block);
    bool right = abc[0] == 0xba7816bf && abc[7] == 0xf20015ad;
    unsigned *best, *digests;
    static unsigned results[kNonces];
    CUDA(cudaMalloc(&best, sizeof(unsigned)));
    CUDA(cudaMalloc(&digests, sizeof(results)));
    CUDA(cudaMemset(best, 0xff, sizeof(unsigned)));
    mine<<<kNonces / 64, 64>>>(0xdeadbeef, 0x12345678, limit, best, digests);
    unsigned found, expected = ~0u, wrong = 0;
    CUDA(cudaMemcpy(&found, best, sizeof(found), cudaMemcpyDeviceToHost));
    CUDA(cudaMemcpy(results, digests, sizeof(results), cudaMemcpyDeviceToHost));
    for (unsigned nonce = 0; nonce < kNonces; ++nonce) {
        unsigned digest[8];
        hashTwice(0xdeadbeef, 0x12345678, nonce, digest);
        wrong += results[nonce] != (digest[0] ^ digest[7]);
        if (digest[0] < limit && nonce < expected)
            expected = nonce;
    }
    std::printf("nonce %u, %u wrong\n", found, wrong);
    return finish(right && wrong == 0 && found == expected && found != ~0u);
}
