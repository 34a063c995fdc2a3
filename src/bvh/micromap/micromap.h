// SPDX-License-Identifier: Apache-2.0
// Opacity micromaps: the format of an array, and the look-up of a hit's state.
//
// A micromap divides a triangle into 4^level equal ones, in barycentric coordinates, and gives each
// a state of 1 or 2 bits. They are numbered along a space-filling curve: the triangle (A, B, C)
// with edge midpoints AB, BC, AC is the four triangles
//
//   0: (A, AB, AC)   1: (AC, BC, AB)   2: (AB, B, BC)   3: (BC, AC, C)
//
// in this order, each divided the same way. The root is (vertex 0, vertex 1, vertex 2).
//
// The number without recursion. Let a, b, c be the barycentrics of a point, as binary fractions,
// and a_k, b_k, c_k their k-th digits. One step down the curve takes the digits in turn: child 0, 2
// or 3 has a, b or c in its upper half, child 1 has none. Children 1 and 3 exchange the roles of A
// and B; child 1 is upside down, which inverts all later digits. Therefore only the difference of
// a's and b's digits matters, and the orientation is a parity:
//   low_k  = !(a_k ^ b_k)                                child 1 or 3
//   s_k    = low_0 ^ ... ^ low_(k-1)                     A and B exchanged
//   high_k = (s_k ? a_k : b_k) ^ c_k                     child 2 or 3
//
// An array is one block without addresses in it: MicromapArrayHeader | MicromapRef[] | states. A
// geometry structure keeps the address of the array and, for each triangle, a MicromapRef, so that
// a look-up reads two places instead of three. Layout of that table: layout.h.
#pragma once

#include "base/inline.h"

#include <cstddef>
#include <cstdint>

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh {

constexpr unsigned kMaxMicromapLevel = 12;

// Numbers of OptixOpacityMicromapFormat.
enum class MicromapFormat : uint32_t { kTwoState = 1, kFourState = 2 };

// Values of the states in 4-state micromaps; 2-state micromaps have the first two.
enum MicromapState : uint32_t {
    kTransparent = 0,
    kOpaque = 1,
    kUnknownTransparent = 2,
    kUnknownOpaque = 3,
    kNoMicromap = 4, // the triangle has no micromap
};

inline uint64_t microTriangleCount(unsigned level) {
    return uint64_t(1) << (2 * level);
}

// Bytes of the states of one micromap: whole bytes, the lowest bits first.
inline uint64_t micromapBytes(unsigned level, MicromapFormat format) {
    const uint64_t bits = microTriangleCount(level) << (format == MicromapFormat::kFourState);
    return (bits + 7) / 8;
}

// A byte in which all micro-triangles have the state.
inline uint32_t filledByte(uint32_t state, MicromapFormat format) {
    return state * (format == MicromapFormat::kTwoState ? 0xFFu : 0x55u);
}
// The used bits of a micromap's bytes; all bits except in the smallest micromaps.
inline uint32_t usedBits(unsigned level, MicromapFormat format) {
    const uint64_t bits = microTriangleCount(level) << (format == MicromapFormat::kFourState);
    return bits >= 8 ? 0xFFu : (1u << bits) - 1;
}

// The first 128 bytes of an array.
struct alignas(128) MicromapArrayHeader {
    uint32_t magic; // kMicromapMagic
    uint32_t version;
    uint64_t usedSize;
    uint64_t refsOffset; // MicromapRef words
    uint64_t dataOffset;
    uint32_t numMicromaps;
    uint32_t pad[23];
};
static_assert(sizeof(MicromapArrayHeader) == 128);
constexpr uint32_t kMicromapMagic = 0x4D4D4253u;
constexpr uint32_t kMicromapVersion = 1;

inline bool looksLikeMicromapArray(const MicromapArrayHeader* header) {
    return header->magic == kMicromapMagic && header->version == kMicromapVersion;
}

// The place of a micromap's states, in one word:
//   bits 0..1   kind    bits 4..7  level, or the state if all of the triangle has the same
//   bits 8..63  place of the states, in bytes from the start of the array
using MicromapRef = uint64_t;
enum MicromapRefKind : uint32_t {
    kRefNone = 0,
    kRefUniform = 1,
    kRefTwoState = 2,
    kRefFourState = 3
};

inline MicromapRef makeUniformRef(MicromapState state) {
    return state == kNoMicromap ? MicromapRef(kRefNone) : MicromapRef(state) << 4 | kRefUniform;
}
inline MicromapRef makeMicromapRef(uint64_t offset, unsigned level, MicromapFormat format) {
    return offset << 8 | uint64_t(level) << 4 |
           (format == MicromapFormat::kTwoState ? kRefTwoState : kRefFourState);
}

// Bit i of the result: whether an odd number of the bits of `a` above bit i are set.
SUNSTONE_INLINE uint32_t parityAbove(uint32_t a) {
    a >>= 1;
    a ^= a >> 1;
    a ^= a >> 2;
    a ^= a >> 4;
    a ^= a >> 8;
    return a;
}

// Spreads bits 0..11 to the even bits.
SUNSTONE_INLINE uint32_t spreadBits(uint32_t a) {
    a = (a | a << 8) & 0x00FF00FFu;
    a = (a | a << 4) & 0x0F0F0F0Fu;
    a = (a | a << 2) & 0x33333333u;
    return (a | a << 1) & 0x55555555u;
}

// The number of the micro-triangle at barycentrics (u, v), u belonging to vertex 1 and v to vertex
// 2. Values outside the triangle, NaN too, are moved into it. Points on a common edge belong to one
// of the triangles there.
SUNSTONE_INLINE uint32_t microTriangleAt(float u, float v, unsigned level) {
    const uint32_t n = 1u << level, last = n - 1;
    const float scale = float(n);
    const float su = u > 0 ? u * scale : 0, sv = v > 0 ? v * scale : 0; // exact
    uint32_t b = su < scale ? uint32_t(su) : last;
    uint32_t c = sv < scale ? uint32_t(sv) : last;
    if (b + c > last)
        (b > c ? b : c) = last - (b > c ? c : b);
    // The square cell (b, c) consists of an upright triangle and an inverted one.
    const bool head = (su - float(b)) + (sv - float(c)) >= 1 && b + c < last;
    const uint32_t a = last - b - c - head;
    const uint32_t low = ~(a ^ b) & last;
    const uint32_t exchanged = parityAbove(low);
    const uint32_t high = (((a & exchanged) | (b & ~exchanged)) ^ c) & last;
    return spreadBits(low) | spreadBits(high) << 1;
}

// The state at (u, v) of the micromap of `ref`, in a structure over `array`.
SUNSTONE_INLINE uint32_t micromapStateAt(const uint8_t* array, MicromapRef ref, float u, float v) {
    const uint32_t kind = ref & 3, level = ref >> 4 & 15;
    if (kind == kRefUniform)
        return level;
    if (kind == kRefNone)
        return kNoMicromap;
    const uint32_t index = microTriangleAt(u, v, level);
    const uint8_t* states = array + (ref >> 8);
    return kind == kRefTwoState ? states[index >> 3] >> (index & 7) & 1
                                : states[index >> 2] >> (2 * (index & 3)) & 3;
}

// The meaning of a state in two-state mode (FORCE_OPACITY_MICROMAP_2_STATE).
SUNSTONE_INLINE uint32_t forcedToTwoStates(uint32_t state) {
    return state == kNoMicromap ? state : state & 1;
}

} // namespace sunstone::bvh

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
