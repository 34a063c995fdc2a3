// SPDX-License-Identifier: Apache-2.0
// Memory of the CPU device: host memory with a table of allocations by address, so that copies out
// of range, double frees and foreign pointers are detected without an access. It lies in address
// ranges of its own (pages.h), and freed memory is inaccessible for a while (quarantine.h). All
// functions may be called from any thread. Read next: pages.h, stream.h.
#pragma once

#include "device/cpu/allocation.h"
#include "device/cpu/quarantine.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <shared_mutex>
#include <vector>

namespace sunstone::device::cpu {

class Memory {
public:
    Memory();

    // Allocates `size` bytes at the start of a page; the contents are undefined. Throws
    // kInvalidValue for size 0 and kOutOfMemory if the machine has less memory.
    void* allocate(size_t size, MemoryKind kind, unsigned flags, const void* owner);
    // The same, filled with zeros.
    void* allocateZeroed(size_t size, MemoryKind kind, unsigned flags, const void* owner);
    // Registers memory of other owners; false if it overlaps registered memory.
    bool adopt(const void* base, size_t size, MemoryKind kind, unsigned flags, const void* owner);
    // Frees memory that starts at `base` if its kind is one of `kinds` and, if `id` is not 0, its
    // id is `id`; otherwise false.
    bool release(const void* base, std::initializer_list<MemoryKind> kinds, uint64_t id = 0);
    // Frees or forgets all memory of this owner.
    void releaseOwner(const void* owner);

    // Reserves addresses without access for later mappings: at `wanted` if they are free. Throws
    // kOutOfMemory.
    uintptr_t reserveAddresses(size_t size, size_t alignment, uintptr_t wanted);
    // Frees reserved addresses; the caller has unmapped everything there.
    void freeAddresses(uintptr_t base, size_t size);

    // Removes access to memory freed so far. Each piece of work of a stream begins with it.
    void sealFreed() { quarantine_.seal(); }

    // The live allocation that contains the address, if any.
    std::optional<Allocation> find(const void* address) const;
    // Whether the whole range lies in one live allocation, or in readable mappings that adjoin.
    bool contains(const void* address, size_t size) const;
    // Whether all mappings in the range are writable; other memory counts as writable.
    bool isWritable(const void* address, size_t size) const;

    size_t allocatedBytes() const;

    // For reports of invalid accesses. `version` changes with every allocation and release.
    uint64_t version() const { return version_.load(std::memory_order_acquire); }
    std::vector<Allocation> live() const;
    // Freed memory that is not reused yet, in the order of freeing.
    std::vector<FreedAllocation> freed() const { return quarantine_.list(); }
    // Allocations that the application never freed, including those freed with their context.
    std::vector<Allocation> leaked() const;

private:
    void* allocate(size_t size, MemoryKind kind, unsigned flags, const void* owner, bool& isZero);
    void retire(const Allocation& allocation, bool withContext);

    mutable std::shared_mutex mutex_;
    std::map<uintptr_t, Allocation> byBase_;
    size_t allocated_ = 0;
    uint64_t nextId_ = 1;
    std::atomic<uint64_t> version_{0};
    std::vector<Allocation> leaked_;
    Quarantine quarantine_;
};

// Whether all pages of the range are mapped (or readable, or readable and writable). A range that
// begins in the address ranges of this device must lie in live allocations. Never faults.
bool isMapped(const void* address, size_t size);
bool isMappedReadable(const void* address, size_t size);
bool isMappedReadWrite(const void* address, size_t size);

// Physical memory of the machine, and its part that can be allocated now, in bytes.
size_t totalMemory();
size_t availableMemory();

Memory& memory();

} // namespace sunstone::device::cpu
