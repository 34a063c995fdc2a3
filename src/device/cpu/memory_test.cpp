// SPDX-License-Identifier: Apache-2.0
// Address ranges and freed memory of the CPU device: the ranges contain nothing else, freed memory
// loses access and is remembered for a while, and the memory that waits for reuse is bounded.
#include "device/cpu/memory.h"

#include "base/error.h"
#include "base/faults.h"
#include "base/readable.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <set>
#include <thread>
#include <vector>

namespace sunstone::device::cpu {
namespace {

constexpr auto kKind = MemoryKind::kDevice;

void* take(size_t size) {
    return memory().allocate(size, kKind, 0, nullptr);
}
void give(void* address) {
    ASSERT_TRUE(memory().release(address, {kKind}));
}
bool isRemembered(const void* address) {
    const std::vector<FreedAllocation> freed = memory().freed();
    return std::any_of(freed.begin(), freed.end(), [&](const FreedAllocation& f) {
        return uintptr_t(address) - f.base < f.size;
    });
}

// Number of lines of a file of /proc/self.
size_t linesOf(const char* path) {
    FILE* file = std::fopen(path, "re");
    size_t lines = 0;
    for (int c = 0; file && (c = std::fgetc(file)) != EOF;)
        lines += c == '\n';
    if (file)
        std::fclose(file);
    return lines;
}

size_t residentBytes() {
    unsigned long all = 0, resident = 0;
    if (FILE* file = std::fopen("/proc/self/statm", "re")) {
        if (std::fscanf(file, "%lu %lu", &all, &resident) != 2)
            resident = 0;
        std::fclose(file);
    }
    return resident * size_t(sysconf(_SC_PAGESIZE));
}

TEST(Memory, LosesAccessWhenItIsFreed) {
    for (const size_t size :
         {size_t(1), size_t(256), size_t(64) << 10, size_t(9) << 20, size_t(64) << 20}) {
        auto* const bytes = static_cast<char*>(take(size));
        EXPECT_EQ(0u, uintptr_t(bytes) % 512);
        std::memset(bytes, 1, size);
        EXPECT_TRUE(isReadable(bytes, size));
        give(bytes);
        memory().sealFreed();
        EXPECT_FALSE(isReadable(bytes, 1)) << size;
        EXPECT_FALSE(isReadable(bytes + size - 1, 1)) << size;
        EXPECT_FALSE(isMapped(bytes, 1)) << size;
        EXPECT_FALSE(isMappedReadWrite(bytes, 1)) << size;
        EXPECT_TRUE(isRemembered(bytes + size - 1)) << size;
        EXPECT_FALSE(memory().release(bytes, {kKind})) << "freed twice";
        EXPECT_NE(bytes, take(size)) << "used again at once";
    }
}

// The system places stacks, files and the heap elsewhere, however much is freed.
TEST(Memory, SharesItsAddressesWithNothing) {
    std::vector<void*> all;
    for (int i = 0; i < 200; ++i)
        all.push_back(take(size_t(1) << 20));
    for (void* address : all)
        give(address);
    for (int i = 0; i < 20; ++i) {
        bool isApart = false;
        std::thread([&] { isApart = !pages().holds(__builtin_frame_address(0)); }).join();
        EXPECT_TRUE(isApart);
        void* const other =
            mmap(nullptr, size_t(1) << 20, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        ASSERT_NE(MAP_FAILED, other);
        EXPECT_FALSE(pages().holds(other));
        EXPECT_FALSE(pages().holds(static_cast<char*>(other) + (size_t(1) << 20) - 1));
        munmap(other, size_t(1) << 20);
    }
    void* const live = take(100);
    EXPECT_TRUE(pages().holds(live));
    give(live);
}

// Frees of all sizes, many times: memory and mappings of the process stay bounded, and addresses
// are used again.
TEST(Memory, IsUsedAgainAfterAWhile) {
    const size_t before = residentBytes(), mappings = linesOf("/proc/self/maps");
    constexpr size_t kMost = Quarantine::kBytes + Pages::kWarmBytes + (size_t(64) << 20);
    for (const size_t size : {size_t(300), size_t(70) << 10, size_t(3) << 20, size_t(48) << 20}) {
        constexpr size_t kTimes = 3 * Quarantine::kAllocations;
        std::set<void*> places;
        for (size_t i = 0; i < kTimes; ++i) {
            void* const next = take(size);
            *static_cast<char*>(next) = 1;
            places.insert(next);
            give(next);
        }
        EXPECT_LT(places.size(), kTimes / 2) << size;
        EXPECT_LT(residentBytes(), before + kMost) << size;
        EXPECT_LT(linesOf("/proc/self/maps"), mappings + 2 * Quarantine::kAllocations + 200)
            << size;
    }
}

// Every second block stays: each freed one is a mapping of its own.
TEST(Memory, KeepsFewMappings) {
    const size_t mappings = linesOf("/proc/self/maps");
    std::vector<void*> kept;
    for (int i = 0; i < 40000; ++i) {
        kept.push_back(take(4096));
        give(take(4096));
    }
    EXPECT_LT(linesOf("/proc/self/maps"), mappings + 2 * Quarantine::kAllocations + 200);
    for (void* address : kept)
        give(address);
}

// Traversal is not compiled with the checks of the memory checker: it must fault on freed
// structures.
TEST(Memory, FreedMemoryHasNoAccessWhileItIsChecked) {
    Quarantine quarantine(true);
    std::vector<Block> blocks;
    for (size_t i = 0; i < Quarantine::kAllocations + 200; ++i) {
        blocks.push_back(pages().take(Pages::pageSize(), false));
        FreedAllocation freed;
        freed.base = blocks.back().begin;
        freed.size = 100;
        quarantine.add(freed, blocks.back(), false, true);
    }
    quarantine.seal();
    const auto isAccessible = [](const Block& block) {
        return isReadable(reinterpret_cast<const void*>(block.begin), 1);
    };
    EXPECT_FALSE(isAccessible(blocks.front()));
    EXPECT_TRUE(isAccessible(blocks.back())) << "each costs mappings";
    quarantine.empty();
}

TEST(Memory, IsZeroOnRequest) {
    for (const size_t size : {size_t(5000), size_t(20) << 20, size_t(40) << 20})
        for (int i = 0; i < 30; ++i) {
            auto* const bytes =
                static_cast<char*>(memory().allocateZeroed(size, kKind, 0, nullptr));
            for (size_t at = 0; at < size; at += 1000)
                ASSERT_EQ(0, bytes[at]) << size << " at " << at;
            std::memset(bytes, 1, size);
            give(bytes);
        }
}

TEST(Memory, ReservesAddresses) {
    constexpr size_t kUnit = size_t(2) << 20;
    const uintptr_t first = memory().reserveAddresses(kUnit, size_t(1) << 32, 0);
    EXPECT_EQ(0u, first % (size_t(1) << 32));
    EXPECT_FALSE(isReadable(reinterpret_cast<void*>(first), 1));
    EXPECT_FALSE(isMapped(reinterpret_cast<void*>(first), 1)) << "nothing may access it";
    memory().freeAddresses(first, kUnit);
    EXPECT_TRUE(isRemembered(reinterpret_cast<void*>(first)));
    EXPECT_NE(first, memory().reserveAddresses(kUnit, kUnit, 0));
    // A wanted address, in the ranges and beside them.
    const uintptr_t inside = memory().reserveAddresses(8 * kUnit, kUnit, 0);
    EXPECT_NE(inside, memory().reserveAddresses(kUnit, kUnit, inside)) << "it is taken";
    constexpr uintptr_t kBeside = 0x600000000000;
    if (!handlesFaults())
        return; // sanitizers have the other addresses
    EXPECT_EQ(kBeside, memory().reserveAddresses(kUnit, kUnit, kBeside));
    EXPECT_TRUE(pages().holds(reinterpret_cast<void*>(kBeside)));
    EXPECT_THROW(memory().reserveAddresses(size_t(1) << 60, kUnit, 0), Error);
}

TEST(Memory, IsFreedByManyThreads) {
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([t] {
            std::vector<char*> mine;
            for (size_t i = 0; i < 4000; ++i) {
                const size_t size = 1 + (i * 7919 + size_t(t) * 31) % (size_t(1) << 18);
                mine.push_back(static_cast<char*>(take(size)));
                mine.back()[0] = mine.back()[size - 1] = char(t);
                if (i % 3 == 0)
                    continue;
                EXPECT_EQ(char(t), mine.back()[0]) << "shared with another thread";
                give(mine.back());
                mine.pop_back();
                if (i % 100 == 0)
                    memory().sealFreed();
            }
            for (char* address : mine) {
                EXPECT_EQ(char(t), address[0]) << "shared with another thread";
                give(address);
            }
        });
    for (std::thread& thread : threads)
        thread.join();
}

} // namespace
} // namespace sunstone::device::cpu
