// SPDX-License-Identifier: Apache-2.0
// The address ranges of the CPU device's memory. Regions of addresses are reserved once, without
// access, and kept until the process ends. The system therefore maps nothing else there: a wrong
// address of device code meets device memory or pages without access, and never a thread's stack or
// the library's own data.
//
// A part of a region is one of
//
//   taken   by a caller of take or reserve
//   warm    a block that was taken before and still has its memory, kept for the next take of its
//           size; warm blocks together have at most kWarmBytes
//   cold    without access and without memory; cold neighbours are merged
//
// Read next: quarantine.h, which returns blocks to this class.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

namespace sunstone::device::cpu {

struct Block {
    uintptr_t begin = 0;
    size_t bytes = 0; // a multiple of the page size
    bool isZero = false;
    explicit operator bool() const { return bytes != 0; }
};

class Pages {
public:
    // Enough to serve programs that allocate and free their buffers for each frame.
    static constexpr size_t kWarmBytes = size_t(256) << 20;
    static constexpr size_t kHugePage = size_t(2) << 20;
    // Larger blocks return their memory to the system when they are freed, as with the C library.
    static constexpr size_t kMostReused = size_t(32) << 20;

    static size_t pageSize();
    // The size of the block that `take` returns. Sizes from some pages to kMostReused are rounded
    // to one of eight sizes between two powers of two, so that warm blocks fit later requests.
    static size_t blockSize(size_t bytes);

    // A block of readable and writable pages with undefined contents. `isHuge`: starts at a
    // multiple of kHugePage and requests huge pages. Empty if the system has no room.
    Block take(size_t bytes, bool isHuge);
    // Addresses without access, at `wanted` if they are free there. Empty if there is no room.
    Block reserve(size_t bytes, size_t alignment, uintptr_t wanted);

    // Takes back a block that is readable and writable.
    void keepWarm(const Block& block, bool isHuge);
    // Removes access and memory of a block that stays taken.
    static void clear(const Block& block);
    // Takes back a cleared or reserved block.
    void keepCold(const Block& block);
    // Returns the memory of all warm blocks to the system.
    void trim();

    // Whether the address lies in a region.
    bool holds(const void* address) const;

private:
    static constexpr size_t kMostRegions = 64;

    // The functions below are called under mutex_.
    Block takeCold(size_t bytes, size_t alignment);
    Block takeColdAt(uintptr_t begin, size_t bytes);
    bool addRegion(size_t bytes, size_t alignment);
    bool addRegionAt(uintptr_t begin, size_t bytes);
    void noteRegion(uintptr_t begin, size_t bytes);
    void addCold(Block block);
    void removeCold(const Block& block);
    void dropWarm();

    struct Region {
        std::atomic<uintptr_t> begin{0}, end{0};
    };
    std::array<Region, kMostRegions> regions_;
    std::atomic<size_t> regionCount_{0};

    std::mutex mutex_; // guards the members below
    std::map<uintptr_t, size_t> coldByPlace_;
    std::set<std::pair<size_t, uintptr_t>> coldBySize_;
    std::unordered_map<size_t, std::vector<uintptr_t>> warm_; // by size; huge ones: size + 1
    size_t warmBytes_ = 0;
};

// Gives or removes access; false, with errno, if the system refuses.
bool setAccess(const Block& block, bool isAccessible);

// The blocks with adjoining ones merged, in the order of addresses.
std::vector<Block> mergedBlocks(std::vector<Block> blocks);

Pages& pages();

} // namespace sunstone::device::cpu
