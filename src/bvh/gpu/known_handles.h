// SPDX-License-Identifier: Apache-2.0
// The valid handles, as a hash table in device memory that the host maintains
// (engine/gpu/structures.h), because kernels cannot test whether an address is mapped. A 64-bit
// number represents the table: its address, aligned to kTableAlignment, and in the low bits the
// shift from a hash to a place. 0: no table, all handles are accepted. With low bits kOfGraph, the
// kernel reads the number from that address when it runs, because a kernel in a graph may run long
// after it was queued.
//
// Kernels may read while the host writes: the host writes whole entries and never moves an entry,
// so that kernels see every entry that was valid when they were queued.
#pragma once

#include "bvh/gpu/portable.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

constexpr uint64_t kTableAlignment = 64;
constexpr uint64_t kOfGraph = kTableAlignment - 1;
constexpr uint64_t kFreeEntry = 0;

// The hash uses the bits of a handle above its tag.
constexpr uint32_t kHashFactor = 0x9E3779B1u, kHashInverse = 0x0E8B2F51u;
static_assert(kHashFactor * kHashInverse == 1);
SUNSTONE_INLINE uint32_t placeOfHandle(uint64_t handle, uint32_t shift) {
    return uint32_t(handle >> 6) * kHashFactor >> shift;
}

// The value that replaces the entry of a removed handle, so that searches continue past it. A
// search for this value as a handle starts at the next place, and never reaches this entry.
SUNSTONE_INLINE uint64_t goneEntry(uint32_t place, uint32_t shift) {
    const uint32_t next = (place + 1) & (~0u >> shift);
    return uint64_t((next << shift | 1u) * kHashInverse) << 6;
}

// The table's number, from a number that may be its address. Not a part of isKnownHandle(), because
// a path tracer's kernel with this code took 1.4 times as long on an H100, although it never
// executed the code.
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
