// SPDX-License-Identifier: Apache-2.0
// Code that host and device share.
#pragma once

#define SIZES(F) F(1) F(2) F(3) F(5) F(8) F(12) F(17) F(33) F(64) F(100) F(128) F(200)
enum { kSizes = 12, kDepthType = kSizes, kRayTypes };

#ifdef __CUDACC__
#define SHARED static __host__ __device__
#else
#define SHARED static
#endif

template <int size>
struct Bytes {
    unsigned char bytes[size];
};
template <int size>
SHARED void fill(Bytes<size>& to, int seed) {
    for (int i = 0; i < size; ++i)
        to.bytes[i] = (unsigned char)(seed + 3 * i);
}
// `from` is 7 i modulo the size. With `i * 7 % size` LLVM 19 vectorises the host's loop wrongly if
// the size is a power of two.
template <int size>
SHARED void shuffle(Bytes<size>& it) {
    for (int i = 0, from = 0; i < size; ++i) {
        it.bytes[i] = (unsigned char)(it.bytes[from] ^ (size + i));
        from += 7;
        while (from >= size)
            from -= size;
    }
}
template <int size>
SHARED int sum(const Bytes<size>& of) {
    unsigned total = 0;
    for (int i = 0; i < size; ++i)
        total = total * 31 + of.bytes[i];
    return int(total);
}
