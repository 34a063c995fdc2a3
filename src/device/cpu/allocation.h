// SPDX-License-Identifier: Apache-2.0
// The CPU device's data about an allocation. Read next: memory.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sunstone::device::cpu {

enum class MemoryKind : uint8_t {
    kDevice,
    kPinned, // host memory allocated by the API
    kManaged,
    kArray,
    kRegistered,      // the application's own, registered with the API; never freed by us
    kModule,          // variables of a loaded module; never freed by us
    kManagedVariable, // the same, in managed memory
    kShared,          // the library's, which host and device code use
    kLent,            // the same, outside the device's address ranges; never freed by us
    kMapped,          // at reserved addresses; flags: 1 readable, 2 writable; never freed by us
};
inline bool isManaged(MemoryKind kind) {
    return kind == MemoryKind::kManaged || kind == MemoryKind::kManagedVariable ||
           kind == MemoryKind::kShared || kind == MemoryKind::kLent;
}

// Return addresses of the application's call, innermost first; empty unless memory is checked.
using CallStack = std::vector<const void*>;

struct Allocation {
    uintptr_t base = 0;
    size_t size = 0;
    MemoryKind kind = MemoryKind::kDevice;
    unsigned flags = 0;                           // as given to the API
    const void* owner = nullptr;                  // context that frees it at its end
    uint64_t id = 0;                              // never reused
    std::shared_ptr<const CallStack> allocatedAt; // only while memory is checked
};

// Memory that was freed and waits in the quarantine.
struct FreedAllocation : Allocation {
    CallStack freedAt;        // empty unless memory is checked
    bool withContext = false; // freed because its context ended
};

} // namespace sunstone::device::cpu
