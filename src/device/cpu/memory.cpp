// SPDX-License-Identifier: Apache-2.0
// See memory.h.
#include "device/cpu/memory.h"

#include "base/config.h"
#include "base/error.h"
#include "base/threads/threads.h"
#include "device/cpu/pages.h"
#include "device/cpu/poison.h"

#include <execinfo.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <mutex>

namespace sunstone::device::cpu {

namespace {

constexpr size_t kHugeFrom = size_t(8) << 20;

bool isOurs(MemoryKind kind) {
    return kind == MemoryKind::kDevice || kind == MemoryKind::kPinned ||
           kind == MemoryKind::kManaged || kind == MemoryKind::kArray ||
           kind == MemoryKind::kShared;
}

bool isChecked() {
    static const bool on = checks("memory");
    return on;
}

// Acceleration structures are read at random: huge pages save most TLB misses.
bool isHuge(size_t size) {
    return size >= kHugeFrom;
}

// A gap follows each allocation, so that calls reject addresses behind it. While memory is checked,
// gaps surround it, so that an access past its end does not reach another allocation. In builds
// with the address sanitizer only accesses of the library are detected.
size_t zoneBefore(size_t size) {
    return !isChecked() ? 0 : isHuge(size) ? Pages::kHugePage : Pages::pageSize();
}
size_t zoneBehind(size_t size) {
    if (isChecked())
        return std::clamp<size_t>(size, 4096, size_t(1) << 20);
    return kPoisons ? 4096 : 64;
}
size_t withZones(size_t size) {
    return zoneBefore(size) + size + zoneBehind(size);
}

// The block that `allocate` took for the memory.
Block blockOf(const Allocation& allocation) {
    return {allocation.base - zoneBefore(allocation.size),
            Pages::blockSize(withZones(allocation.size))};
}

// Marks or unmarks the gaps around the memory in its block.
void markZones(void (*mark)(uintptr_t, size_t), uintptr_t base, size_t size, const Block& block) {
    mark(block.begin, base - block.begin);
    mark(base + size, block.begin + block.bytes - (base + size));
}

CallStack callStack() {
    constexpr int kFrames = 24;
    void* frames[kFrames];
    const int count = backtrace(frames, kFrames);
    return CallStack(frames + 1, frames + std::max(1, count));
}

// The entry that contains the address, or end.
template <class Map>
auto entryOf(Map& map, uintptr_t address) {
    auto it = map.upper_bound(address);
    if (it == map.begin())
        return map.end();
    --it;
    return address - it->first < it->second.size ? it : map.end();
}

} // namespace

Memory::Memory() : quarantine_(isChecked()) {}

void* Memory::allocate(size_t size, MemoryKind kind, unsigned flags, const void* owner) {
    bool isZero = false;
    return allocate(size, kind, flags, owner, isZero);
}

void* Memory::allocateZeroed(size_t size, MemoryKind kind, unsigned flags, const void* owner) {
    bool isZero = false;
    void* const memory = allocate(size, kind, flags, owner, isZero);
    return isZero ? memory : std::memset(memory, 0, size);
}

void* Memory::allocate(size_t size, MemoryKind kind, unsigned flags, const void* owner,
                       bool& isZero) {
    if (size == 0)
        fail(Code::kInvalidValue, "an allocation of 0 bytes");
    // The kernel overcommits: reject sizes that can never be used.
    if (size > totalMemory() - std::min(totalMemory(), allocatedBytes()))
        fail(Code::kOutOfMemory, "no memory for ", size, " bytes: the device has ", totalMemory());
    Block block = pages().take(withZones(size), isHuge(size));
    if (!block) { // memory that waits for reuse may make room
        quarantine_.empty();
        pages().trim();
        block = pages().take(withZones(size), isHuge(size));
    }
    if (!block)
        fail(Code::kOutOfMemory, "no memory for ", size, " bytes");
    isZero = block.isZero;
    const uintptr_t base = block.begin + zoneBefore(size);
    if (!block.isZero)
        unpoison(base, size);
    markZones(poison, base, size, block);
    Allocation made{base, size, kind, flags, owner};
    if (isChecked())
        made.allocatedAt = std::make_shared<const CallStack>(callStack());
    std::unique_lock lock(mutex_);
    made.id = nextId_++;
    byBase_[made.base] = std::move(made);
    allocated_ += size;
    ++version_;
    return reinterpret_cast<void*>(base);
}

bool Memory::adopt(const void* base, size_t size, MemoryKind kind, unsigned flags,
                   const void* owner) {
    const uintptr_t begin = uintptr_t(base);
    if (size == 0 || begin + size < begin)
        return false;
    std::unique_lock lock(mutex_);
    auto next = byBase_.lower_bound(begin);
    if (next != byBase_.end() && next->first < begin + size)
        return false;
    if (entryOf(byBase_, begin) != byBase_.end())
        return false;
    byBase_[begin] = {begin, size, kind, flags, owner, nextId_++};
    ++version_;
    return true;
}

void Memory::retire(const Allocation& allocation, bool withContext) {
    const Block block = blockOf(allocation);
    if (block.bytes <= Pages::kMostReused)
        poison(block.begin, block.bytes);
    else // it loses access at once
        markZones(unpoison, allocation.base, allocation.size, block);
    quarantine_.add({allocation, isChecked() ? callStack() : CallStack(), withContext}, block,
                    isHuge(allocation.size), true);
}

bool Memory::release(const void* base, std::initializer_list<MemoryKind> kinds, uint64_t id) {
    Allocation dead;
    {
        std::unique_lock lock(mutex_);
        auto it = byBase_.find(uintptr_t(base));
        if (it == byBase_.end() || (id != 0 && it->second.id != id) ||
            std::find(kinds.begin(), kinds.end(), it->second.kind) == kinds.end())
            return false;
        dead = std::move(it->second);
        byBase_.erase(it);
        if (isOurs(dead.kind))
            allocated_ -= dead.size;
        ++version_;
    }
    if (isOurs(dead.kind))
        retire(dead, false);
    return true;
}

void Memory::releaseOwner(const void* owner) {
    std::vector<Allocation> dead;
    {
        std::unique_lock lock(mutex_);
        for (auto it = byBase_.begin(); it != byBase_.end();) {
            if (it->second.owner != owner) {
                ++it;
                continue;
            }
            if (isOurs(it->second.kind)) {
                allocated_ -= it->second.size;
                dead.push_back(std::move(it->second));
            }
            it = byBase_.erase(it);
        }
        if (isChecked())
            leaked_.insert(leaked_.end(), dead.begin(), dead.end());
        ++version_;
    }
    for (const Allocation& allocation : dead)
        retire(allocation, true);
}

uintptr_t Memory::reserveAddresses(size_t size, size_t alignment, uintptr_t wanted) {
    Block block = pages().reserve(size, alignment, wanted);
    if (!block) {
        quarantine_.empty();
        pages().trim();
        block = pages().reserve(size, alignment, wanted);
    }
    if (!block)
        fail(Code::kOutOfMemory, "no room for ", size, " bytes of addresses");
    return block.begin;
}

void Memory::freeAddresses(uintptr_t base, size_t size) {
    quarantine_.add({{base, size, MemoryKind::kMapped}, {}, false}, {base, size}, false, false);
}

std::optional<Allocation> Memory::find(const void* address) const {
    std::shared_lock lock(mutex_);
    auto it = entryOf(byBase_, uintptr_t(address));
    if (it == byBase_.end())
        return std::nullopt;
    return it->second;
}

bool Memory::contains(const void* address, size_t size) const {
    std::shared_lock lock(mutex_);
    uintptr_t at = uintptr_t(address);
    for (auto it = entryOf(byBase_, at); it != byBase_.end(); it = byBase_.find(at)) {
        const Allocation& allocation = it->second;
        const bool isMapped = allocation.kind == MemoryKind::kMapped;
        if (isMapped && allocation.flags == 0)
            return false;
        const size_t rest = allocation.size - (at - allocation.base);
        if (size <= rest || !isMapped)
            return size <= rest;
        size -= rest;
        at += rest;
    }
    return false;
}

bool Memory::isWritable(const void* address, size_t size) const {
    std::shared_lock lock(mutex_);
    const uintptr_t begin = uintptr_t(address);
    for (auto it = entryOf(byBase_, begin); it != byBase_.end() && it->first < begin + size; ++it)
        if (it->second.kind == MemoryKind::kMapped && !(it->second.flags & 2))
            return false;
    return true;
}

std::vector<Allocation> Memory::live() const {
    std::shared_lock lock(mutex_);
    std::vector<Allocation> all;
    for (const auto& [base, allocation] : byBase_)
        all.push_back(allocation);
    return all;
}

std::vector<Allocation> Memory::leaked() const {
    std::shared_lock lock(mutex_);
    std::vector<Allocation> all = leaked_;
    for (const auto& [base, allocation] : byBase_)
        if (isOurs(allocation.kind) && allocation.kind != MemoryKind::kArray &&
            allocation.kind != MemoryKind::kShared)
            all.push_back(allocation);
    return all;
}

size_t Memory::allocatedBytes() const {
    std::shared_lock lock(mutex_);
    return allocated_;
}

bool isMapped(const void* address, size_t size) {
    const uintptr_t page = uintptr_t(sysconf(_SC_PAGESIZE));
    const uintptr_t begin = uintptr_t(address);
    // Memory in the thread's frames, such as most parameters of launches, needs no system call.
    const StackBounds stack = stackOfThread();
    const auto frame = uintptr_t(__builtin_frame_address(0));
    if (frame >= stack.begin && frame <= begin && begin <= stack.end && size <= stack.end - begin)
        return true;
    if (begin < page || begin + size < begin)
        return false;
    if (pages().holds(address))
        return memory().contains(address, size);
    uintptr_t at = begin & ~(page - 1);
    const uintptr_t end = size ? begin + size : begin + 1;
    if (pages().holds(reinterpret_cast<const void*>(end - 1)))
        return false; // it runs into this device's addresses
    // mincore returns ENOMEM for an unmapped page; whether pages are resident is irrelevant.
    static constexpr size_t kPagesAtOnce = 4096;
    unsigned char resident[kPagesAtOnce];
    while (at < end) {
        const size_t bytes = std::min<size_t>(end - at, kPagesAtOnce * page);
        if (mincore(reinterpret_cast<void*>(at), bytes, resident) != 0)
            return false;
        at += bytes;
        if (at < begin)
            return false;
    }
    return true;
}

namespace {

bool isMappedWith(const void* address, size_t size, bool isWritable) {
    uintptr_t at = uintptr_t(address);
    const uintptr_t end = at + std::max<size_t>(size, 1);
    if (!at || end < at)
        return false;
    if (pages().holds(address))
        return memory().contains(address, size) &&
               (!isWritable || memory().isWritable(address, size));
    FILE* maps = std::fopen("/proc/self/maps", "re");
    if (!maps)
        return false;
    char line[512];
    bool found = false;
    while (!found && std::fgets(line, sizeof line, maps)) {
        unsigned long begin = 0, stop = 0;
        char rights[5] = {};
        if (std::sscanf(line, "%lx-%lx %4s", &begin, &stop, rights) != 3)
            continue; // the rest of a long line
        if (at < begin)
            break;
        if (at >= stop)
            continue;
        if (rights[0] != 'r' || (isWritable && rights[1] != 'w'))
            break;
        at = stop;
        found = at >= end;
    }
    std::fclose(maps);
    return found;
}

} // namespace

bool isMappedReadable(const void* address, size_t size) {
    return isMappedWith(address, size, false);
}

bool isMappedReadWrite(const void* address, size_t size) {
    return isMappedWith(address, size, true);
}

size_t totalMemory() {
    static const size_t total = size_t(sysconf(_SC_PHYS_PAGES)) * size_t(sysconf(_SC_PAGESIZE));
    return total;
}

size_t availableMemory() {
    size_t available = size_t(sysconf(_SC_AVPHYS_PAGES)) * size_t(sysconf(_SC_PAGESIZE));
    if (FILE* file = std::fopen("/proc/meminfo", "re")) {
        char line[128];
        unsigned long kilobytes = 0;
        while (std::fgets(line, sizeof line, file))
            if (std::sscanf(line, "MemAvailable: %lu kB", &kilobytes) == 1)
                available = size_t(kilobytes) * 1024;
        std::fclose(file);
    }
    return std::min(available, totalMemory());
}

Memory& memory() {
    static Memory* instance = new Memory; // outlives every thread that may still copy at exit
    return *instance;
}

} // namespace sunstone::device::cpu
