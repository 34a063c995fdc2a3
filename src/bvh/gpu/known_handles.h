// SPDX-License-Identifier: Apache-2.0
// Valid handles, for kernels, which cannot test whether an address is mapped: a hash table in
// device memory that the host maintains (engine/gpu/structures.h). A number of 64 bits stands for
// the table: its address, which has kTableAlignment, and in the low bits the shift that turns a
// hash into a place. 0: no table, all handles are accepted. With low bits kOfGraph, the number
// itself is read from that address when the kernel runs, because a kernel in a graph may run long
// after it was queued.
//
// Kernels may read while the host writes: the host writes whole entries and never moves one, so
// that kernels see every entry that was valid when they were queued.
#pragma once

#include "bvh/gpu/portable.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

constexpr uint64_t kTableAlignment = 64;
constexpr uint64_t kOfGraph = kTableAlignment - 1;
constexpr uint64_t kFreeEntry = 0;

// Hash of handles, which differ above their tags.
constexpr uint32_t kHashFactor = 0x9E3779B1u, kHashInverse = 0x0E8B2F51u;
static_assert(kHashFactor * kHashInverse == 1);
SUNSTONE_INLINE uint32_t placeOfHandle(uint64_t handle, uint32_t shift) {
    return uint32_t(handle >> 6) * kHashFactor >> shift;
}

// Replaces the entry of a removed handle, so that searches continue past it. A search for this
// number itself as a handle starts at the next place, and never reaches this one.
SUNSTONE_INLINE uint64_t goneEntry(uint32_t place, uint32_t shift) {
    const uint32_t next = (place + 1) & (~0u >> shift);
    return uint64_t((next << shift | 1u) * kHashInverse) << 6;
}

// The table's number, from one that may be the address of it. Not a part of isKnownHandle(): a path
// tracer's kernel that had these lines took an H100 1.4 times as long, although it never executed
// them.
SUNSTONE_INLINE uint64_t knownNow(uint64_t known) {
    return (known & kOfGraph) == kOfGraph
               ? *reinterpret_cast<const volatile uint64_t*>(known & ~kOfGraph)
               : known;
}

// The null handle, which is never hit, is not a known handle.
SUNSTONE_INLINE bool isKnownHandle(uint64_t known, uint64_t handle) {
    const auto* const table = reinterpret_cast<const uint64_t*>(known & ~(kTableAlignment - 1));
    if (!table)
        return true;
    const uint32_t shift = uint32_t(known & (kTableAlignment - 1));
    uint32_t place = placeOfHandle(handle, shift);
    for (;;) { // the host leaves free entries
        const uint64_t entry = table[place];
        if (entry == handle || entry == kFreeEntry)
            return entry == handle && entry != kFreeEntry;
        place = (place + 1) & (~0u >> shift);
    }
}

} // namespace sunstone::bvh::gpu

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
