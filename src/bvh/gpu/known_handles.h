// SPDX-License-Identifier: Apache-2.0
// Which handles lead somewhere, for kernels, which cannot ask whether there is memory at an
// address: a hash table in device memory that the host keeps (engine/gpu/structures.h). A number of 64 bits
// stands for it: its address, which has kTableAlignment, and in the low bits by how much a hash is
// shifted to be a place. 0: there is no table, and all handles are taken as they are. Where the low
// bits are kOfGraph, the number is at the address, as it is when a kernel runs that was queued long
// before, in a graph.
//
// Readers may run while the host writes, a whole entry at a time: none ever changes its place, so
// that readers see what was there before they were queued.
#pragma once

#include "bvh/gpu/portable.h"

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

namespace sunstone::bvh::gpu {

constexpr uint64_t kTableAlignment = 64;
constexpr uint64_t kOfGraph = kTableAlignment - 1;
constexpr uint64_t kFreeEntry = 0;

// Of handles, which differ above their tags.
constexpr uint32_t kHashFactor = 0x9E3779B1u, kHashInverse = 0x0E8B2F51u;
static_assert(kHashFactor * kHashInverse == 1);
SUNSTONE_GPU_INLINE uint32_t placeOfHandle(uint64_t handle, uint32_t shift) {
    return uint32_t(handle >> 6) * kHashFactor >> shift;
}

// For the place of a handle that is gone; those behind it are searched on. Whoever is given this very
// number as a handle searches from the next place on, and never comes to this one.
SUNSTONE_GPU_INLINE uint64_t goneEntry(uint32_t place, uint32_t shift) {
    const uint32_t next = (place + 1) & (~0u >> shift);
    return uint64_t((next << shift | 1u) * kHashInverse) << 6;
}

// What stands for the table, of what may lead there. Not a part of isKnownHandle(): a path tracer's
// kernel that had these lines took an H100 1.4 times as long, although it never came there.
SUNSTONE_GPU_INLINE uint64_t knownNow(uint64_t known) {
    return (known & kOfGraph) == kOfGraph
               ? *reinterpret_cast<const volatile uint64_t*>(known & ~kOfGraph)
               : known;
}

// The null handle, which is never hit, is none of the others.
SUNSTONE_GPU_INLINE bool isKnownHandle(uint64_t known, uint64_t handle) {
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
