// SPDX-License-Identifier: Apache-2.0
// See pages.h. Source: Linux manual, mmap(2), mprotect(2) and madvise(2).
#include "device/cpu/pages.h"

#include "base/error.h"
#include "base/log.h"
#include "device/cpu/memory.h"
#include "device/cpu/poison.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <iterator>

namespace sunstone::device::cpu {

namespace {

// New small blocks are made together, because one system call gives all of them access.
constexpr size_t kTogetherBytes = size_t(256) << 10;

constexpr int kNoAccess = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE;

uintptr_t alignUp(uintptr_t address, size_t alignment) {
    return (address + alignment - 1) & ~uintptr_t(alignment - 1);
}

void* pointerOf(uintptr_t address) {
    return reinterpret_cast<void*>(address);
}

// A region is as large as all memory of the machine, with room for freed addresses. If the process
// has a limit of addresses, regions are smaller, because other uses need most addresses.
size_t usualRegion() {
    static const size_t usual = [] {
        size_t bytes = 2 * totalMemory() + (size_t(64) << 30);
        rlimit limit{};
        if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
            bytes = std::min<size_t>(bytes, limit.rlim_cur / 4);
        return bytes / Pages::kHugePage * Pages::kHugePage;
    }();
    return usual;
}

size_t keyOf(size_t bytes, bool isHuge) {
    return bytes + isHuge;
}

} // namespace

size_t Pages::pageSize() {
    static const size_t size = size_t(sysconf(_SC_PAGESIZE));
    return size;
}

size_t Pages::blockSize(size_t bytes) {
    size_t unit = pageSize();
    if (bytes > 16 * unit && bytes <= kMostReused)
        unit = std::max(unit, std::bit_floor(bytes) / 8);
    return (bytes + unit - 1) / unit * unit;
}

bool setAccess(const Block& block, bool isAccessible) {
    return mprotect(pointerOf(block.begin), block.bytes,
                    isAccessible ? PROT_READ | PROT_WRITE : PROT_NONE) == 0;
}

std::vector<Block> mergedBlocks(std::vector<Block> blocks) {
    std::sort(blocks.begin(), blocks.end(),
              [](const Block& a, const Block& b) { return a.begin < b.begin; });
    std::vector<Block> merged;
    for (const Block& block : blocks) {
        if (!merged.empty() && merged.back().begin + merged.back().bytes == block.begin)
            merged.back().bytes += block.bytes;
        else
            merged.push_back(block);
    }
    return merged;
}

Block Pages::take(size_t bytes, bool isHuge) {
    const size_t size = blockSize(bytes);
    if (size < bytes)
        return {};
    std::lock_guard lock(mutex_);
    std::vector<uintptr_t>& ready = warm_[keyOf(size, isHuge)];
    if (!ready.empty()) {
        const Block block{ready.back(), size};
        ready.pop_back();
        warmBytes_ -= size;
        return block;
    }
    const size_t count = isHuge ? 1 : std::max<size_t>(1, kTogetherBytes / size);
    const Block fresh = takeCold(count * size, isHuge ? kHugePage : pageSize());
    if (!fresh)
        return {};
    if (!setAccess(fresh, true)) {
        addCold(fresh);
        return {};
    }
    if (isHuge)
        madvise(pointerOf(fresh.begin), size, MADV_HUGEPAGE); // only advice
    for (size_t i = count; i-- > 1;)
        ready.push_back(fresh.begin + i * size);
    warmBytes_ += (count - 1) * size;
    return {fresh.begin, size, true};
}

Block Pages::reserve(size_t bytes, size_t alignment, uintptr_t wanted) {
    std::lock_guard lock(mutex_);
    if (wanted && wanted % alignment == 0) {
        if (const Block block = takeColdAt(wanted, bytes))
            return block;
        // Some regions are left for later requests.
        if (regionCount_ < kMostRegions / 2 && addRegionAt(wanted, bytes))
            return takeColdAt(wanted, bytes);
    }
    return takeCold(bytes, std::max(alignment, pageSize()));
}

void Pages::keepWarm(const Block& block, bool isHuge) {
    std::lock_guard lock(mutex_);
    if (block.bytes > kWarmBytes) {
        clear(block);
        unpoison(block.begin, block.bytes);
        addCold(block);
        return;
    }
    if (warmBytes_ + block.bytes > kWarmBytes)
        dropWarm();
    warm_[keyOf(block.bytes, isHuge)].push_back(block.begin);
    warmBytes_ += block.bytes;
}

void Pages::clear(const Block& block) {
    // A mapping without access in place of the old one: its memory returns to the system.
    if (mmap(pointerOf(block.begin), block.bytes, PROT_NONE, kNoAccess | MAP_FIXED, -1, 0) ==
        MAP_FAILED)
        log(LogLevel::kError, "device",
            message("freed memory cannot be returned to the system: ", std::strerror(errno)));
}

void Pages::keepCold(const Block& block) {
    std::lock_guard lock(mutex_);
    addCold(block);
}

void Pages::trim() {
    std::lock_guard lock(mutex_);
    dropWarm();
}

bool Pages::holds(const void* address) const {
    const size_t count = regionCount_.load(std::memory_order_acquire);
    for (size_t i = 0; i < count; ++i)
        if (uintptr_t(address) >= regions_[i].begin.load(std::memory_order_relaxed) &&
            uintptr_t(address) < regions_[i].end.load(std::memory_order_relaxed))
            return true;
    return false;
}

Block Pages::takeCold(size_t bytes, size_t alignment) {
    for (int tries = 0; tries < 2; ++tries) {
        for (auto fit = coldBySize_.lower_bound({bytes, 0}); fit != coldBySize_.end(); ++fit) {
            const uintptr_t begin = alignUp(fit->second, alignment);
            const uintptr_t end = fit->second + fit->first;
            if (begin >= fit->second && begin < end && bytes <= end - begin)
                return takeColdAt(begin, bytes);
        }
        if (!addRegion(bytes, alignment))
            break;
    }
    return {};
}

// The cold block at that place, or an empty one.
Block Pages::takeColdAt(uintptr_t begin, size_t bytes) {
    auto found = coldByPlace_.upper_bound(begin);
    if (found == coldByPlace_.begin())
        return {};
    --found;
    const Block whole{found->first, found->second};
    const size_t before = begin - whole.begin;
    if (before >= whole.bytes || bytes > whole.bytes - before)
        return {};
    removeCold(whole);
    if (before)
        addCold({whole.begin, before});
    if (const size_t behind = whole.bytes - before - bytes)
        addCold({begin + bytes, behind});
    return {begin, bytes};
}

bool Pages::addRegion(size_t bytes, size_t alignment) {
    size_t least = 0;
    if (__builtin_add_overflow(bytes, std::max(alignment, kHugePage) + kHugePage, &least) ||
        regionCount_ == kMostRegions)
        return false;
    least = least / kHugePage * kHugePage;
    for (size_t size = std::max(least, usualRegion());; size = std::max(least, size / 2)) {
        void* const memory = mmap(nullptr, size, PROT_NONE, kNoAccess, -1, 0);
        if (memory != MAP_FAILED) {
            noteRegion(uintptr_t(memory), size);
            return true;
        }
        if (size == least)
            return false;
    }
}

bool Pages::addRegionAt(uintptr_t begin, size_t bytes) {
    void* const memory =
        mmap(pointerOf(begin), bytes, PROT_NONE, kNoAccess | MAP_FIXED_NOREPLACE, -1, 0);
    if (memory == MAP_FAILED)
        return false;
    if (memory != pointerOf(begin)) { // systems before Linux 4.17 take the address as a hint
        munmap(memory, bytes);
        return false;
    }
    noteRegion(begin, bytes);
    return true;
}

void Pages::noteRegion(uintptr_t begin, size_t bytes) {
    const size_t count = regionCount_.load(std::memory_order_relaxed);
    regions_[count].begin.store(begin, std::memory_order_relaxed);
    regions_[count].end.store(begin + bytes, std::memory_order_relaxed);
    regionCount_.store(count + 1, std::memory_order_release);
    addCold({begin, bytes});
}

void Pages::addCold(Block block) {
    const auto behind = coldByPlace_.find(block.begin + block.bytes);
    if (behind != coldByPlace_.end()) {
        const Block other{behind->first, behind->second};
        removeCold(other);
        block.bytes += other.bytes;
    }
    const auto next = coldByPlace_.lower_bound(block.begin);
    if (next != coldByPlace_.begin()) {
        const Block before{std::prev(next)->first, std::prev(next)->second};
        if (before.begin + before.bytes == block.begin) {
            removeCold(before);
            block = {before.begin, before.bytes + block.bytes};
        }
    }
    coldByPlace_[block.begin] = block.bytes;
    coldBySize_.insert({block.bytes, block.begin});
}

void Pages::removeCold(const Block& block) {
    coldByPlace_.erase(block.begin);
    coldBySize_.erase({block.bytes, block.begin});
}

// Otherwise blocks of sizes that the program no longer requests would stay for ever.
void Pages::dropWarm() {
    std::vector<Block> blocks;
    for (auto& [key, places] : warm_)
        for (const uintptr_t place : places)
            blocks.push_back({place, key & ~size_t(1)});
    for (const Block& block : mergedBlocks(std::move(blocks))) {
        clear(block);
        unpoison(block.begin, block.bytes);
        addCold(block);
    }
    warm_.clear();
    warmBytes_ = 0;
}

Pages& pages() {
    static Pages* instance = new Pages; // outlives every thread that may still free memory at exit
    return *instance;
}

} // namespace sunstone::device::cpu
