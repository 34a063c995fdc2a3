// SPDX-License-Identifier: Apache-2.0
// Freed memory of the CPU device. It stays without access for a while, so that a late access of
// device code is a fault at an address whose allocation is known. After that its pages serve later
// allocations.
//
// Frees are gathered and lose access together (seal) before the next work of a stream begins, so
// that a program pays one system call for many frees. Memory of more than Pages::kMostReused bytes
// returns to the system at once; only its addresses wait.
//
//   what waits                 limit
//   memory                     kBytes: it is lost to the machine, and a program that frees and
//                              allocates in turn should find its memory in a cache
//   separate ranges            kAllocations: each may cost two of the 65,530 mappings that Linux
//                              grants a process
//   addresses without memory   kAddresses: a small part of a region of pages.h
//
// The memory sealed last always waits, even one large block.
//
// The memory checker checks the accesses of programs itself, but not those of traversal. While it
// is on, the limit is kCheckedBytes, and only kAllocations separate ranges lose access.
#pragma once

#include "device/cpu/allocation.h"
#include "device/cpu/pages.h"

#include <atomic>
#include <deque>
#include <mutex>
#include <vector>

namespace sunstone::device::cpu {

class Quarantine {
public:
    static constexpr size_t kBytes = size_t(16) << 20;
    static constexpr size_t kAllocations = 4096;
    static constexpr size_t kAddresses = size_t(16) << 30;
    static constexpr size_t kCheckedBytes = size_t(256) << 20;

    explicit Quarantine(bool isChecked) : isChecked_(isChecked) {}

    // `hasMemory`: the block has access and memory, as from Pages::take; else it is a reservation.
    void add(FreedAllocation freed, Block block, bool isHuge, bool hasMemory);
    // On return, all memory that was added before this call has no access.
    void seal() {
        if (unsealed_.load(std::memory_order_acquire) != 0)
            sealNow();
    }
    // Returns all memory to Pages.
    void empty();
    std::vector<FreedAllocation> list() const; // in the order of freeing

private:
    static constexpr size_t kTogether = 64;
    static constexpr size_t kTogetherBytes = size_t(8) << 20;

    struct Entry {
        FreedAllocation freed;
        Block block;
        bool isHuge = false, hasMemory = false;
    };
    // Memory that was sealed together.
    struct Group {
        std::vector<Entry> entries;
        std::vector<Block> sealed; // without access, which they get back on return
        size_t bytes = 0;          // of memory
        size_t addresses = 0;      // without memory
    };

    void sealNow();
    // Called under mutex_.
    void close();
    void releaseOldest();
    bool isOverLimit() const;

    const bool isChecked_;
    std::atomic<size_t> unsealed_{0}; // entries of open_
    mutable std::mutex mutex_;
    Group open_;
    std::deque<Group> groups_;
    size_t bytes_ = 0, addresses_ = 0, allocations_ = 0; // of groups_
};

} // namespace sunstone::device::cpu
