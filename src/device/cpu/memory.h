// SPDX-License-Identifier: Apache-2.0
// Memory of the CPU device: host memory whose allocations are remembered by address, so that copies
// out of range, double frees and foreign pointers are detected without accessing them. All
// functions may be called from any thread. Read next: stream.h.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <vector>

namespace sunstone::device::cpu {

enum class MemoryKind : uint8_t {
    kDevice,
    kPinned, // host memory allocated by the API
    kManaged,
    kRegistered, // the application's own, registered with the API; never freed by us
    kModule,     // variables of a loaded module; never freed by us
    kManagedVariable, // the same, in managed memory
    kMapped, // at reserved addresses; flags: 1 readable, 2 writable; never freed by us
};
inline bool isManaged(MemoryKind kind) {
    return kind == MemoryKind::kManaged || kind == MemoryKind::kManagedVariable;
}

// Return addresses of the application's call, innermost first; empty unless memory is checked.
using CallStack = std::vector<const void*>;

struct Allocation {
    uintptr_t base = 0;
    size_t size = 0;
    MemoryKind kind = MemoryKind::kDevice;
    unsigned flags = 0;          // as given to the API
    const void* owner = nullptr; // context that frees it at its end
    uint64_t id = 0;             // never reused
    std::shared_ptr<const CallStack> allocatedAt; // only while memory is checked
};

// Memory that was freed while memory is checked.
struct FreedAllocation : Allocation {
    CallStack freedAt;
    bool withContext = false; // not freed by itself: its context ended
};

class Memory {
public:
    static constexpr size_t kAlignment = 512;

    // Allocates `size` bytes, aligned to kAlignment; the contents are undefined. Throws
    // kInvalidValue for size 0 and kOutOfMemory if the machine has less memory.
    void* allocate(size_t size, MemoryKind kind, unsigned flags, const void* owner);
    // Registers memory of other owners; false if it overlaps registered memory.
    bool adopt(const void* base, size_t size, MemoryKind kind, unsigned flags, const void* owner);
    // Frees memory that starts at `base` if its kind is one of `kinds` and, if `id` is not 0, its
    // id is `id`; otherwise false.
    bool release(const void* base, std::initializer_list<MemoryKind> kinds, uint64_t id = 0);
    // Frees or forgets all memory of this owner.
    void releaseOwner(const void* owner);

    // The live allocation that contains the address, if any.
    std::optional<Allocation> find(const void* address) const;
    // Whether the whole range lies in one live allocation, or in readable mappings that adjoin.
    bool contains(const void* address, size_t size) const;
    // Whether all mappings in the range are writable; other memory counts as writable.
    bool isWritable(const void* address, size_t size) const;

    size_t allocatedBytes() const;

    // For the memory checker. Freed memory is not reused for a while, so that late accesses to it
    // are recognised. `version` changes with every allocation and release.
    uint64_t version() const { return version_.load(std::memory_order_acquire); }
    std::vector<Allocation> live() const;
    std::vector<FreedAllocation> freed() const; // the latest, in the order of freeing
    // Allocations that the application never freed, including those freed with their context.
    std::vector<Allocation> leaked() const;

private:
    void retire(const Allocation& allocation, bool withContext, std::vector<Allocation>& dead);

    mutable std::shared_mutex mutex_;
    std::map<uintptr_t, Allocation> byBase_;
    size_t allocated_ = 0;
    uint64_t nextId_ = 1;
    std::atomic<uint64_t> version_{0};
    std::deque<FreedAllocation> freed_;
    size_t freedBytes_ = 0;
    std::vector<Allocation> leaked_;
};

// Whether all pages of the range are mapped (and, if asked, writable). Never faults.
bool isMapped(const void* address, size_t size);
bool isMappedReadWrite(const void* address, size_t size);

// Physical memory of the machine, and its part that can be allocated now, in bytes.
size_t totalMemory();
size_t availableMemory();

Memory& memory();

} // namespace sunstone::device::cpu
