// SPDX-License-Identifier: Apache-2.0
// Whether the host may access a range, without a fault. Source: Linux manual, process_vm_readv(2),
// madvise(2) and proc(5).
#include "device/device.h"
#include "engine/queries/queries.h"

#include <sys/mman.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace sunstone::engine {
namespace {

constexpr uint64_t kPage = 4096;
constexpr uint64_t kAddressEnd = uint64_t(1) << 47;
constexpr size_t kFewPages = 64;

bool isInAddressSpace(uint64_t address, uint64_t bytes) {
    return address >= kPage && bytes <= kAddressEnd && address <= kAddressEnd - bytes;
}

// Lets the kernel read a byte of each page, which returns an error instead of a fault. False if a
// page cannot be read, or if the system forbids the call.
bool canRead(uint64_t address, uint64_t bytes) {
    uint8_t values[kFewPages + 1];
    iovec there[kFewPages + 1];
    size_t count = 0;
    for (uint64_t at = address; at < address + bytes; at = (at / kPage + 1) * kPage)
        there[count++] = {reinterpret_cast<void*>(at), 1};
    const iovec mine = {values, count};
    return process_vm_readv(getpid(), &mine, 1, there, count, 0) == ssize_t(count);
}

// The same for writing: prepares the pages and keeps their contents, which other queries may be
// writing. False on Linux before 5.14.
bool canWrite(uint64_t address, uint64_t bytes) {
    constexpr int kPopulateWrite = 23; // MADV_POPULATE_WRITE
    const uint64_t begin = address / kPage * kPage;
    return madvise(reinterpret_cast<void*>(begin), address + bytes - begin, kPopulateWrite) == 0;
}

// The same from the list of the process's mappings, which takes longer for few pages.
bool isMapped(uint64_t address, uint64_t bytes, bool written) {
    FILE* const maps = std::fopen("/proc/self/maps", "re");
    if (!maps)
        return false;
    uint64_t at = address;
    const uint64_t end = address + bytes;
    char line[512];
    bool lineStarts = true;
    while (at < end && std::fgets(line, sizeof(line), maps)) {
        unsigned long first, last;
        char access[5] = "";
        if (lineStarts && std::sscanf(line, "%lx-%lx %4s", &first, &last, access) == 3 &&
            last > at) {
            if (first > at || access[0] != 'r' || (written && access[1] != 'w'))
                break;
            at = last;
        }
        lineStarts = std::strchr(line, '\n') != nullptr;
    }
    std::fclose(maps);
    return at >= end;
}

bool isHostMemory(const void* start, uint64_t bytes, bool written) {
    const auto address = uint64_t(start);
    bytes = std::max<uint64_t>(bytes, 1);
    if (!isInAddressSpace(address, bytes))
        return false;
    // Freed memory of the CPU device keeps its access until a stream runs.
    if (device::isCpuDeviceAddress(start))
        return device::cpuDevice().isAccessible(start, bytes);
    return (bytes <= (kFewPages - 1) * kPage &&
            (written ? canWrite(address, bytes) : canRead(address, bytes))) ||
           isMapped(address, bytes, written);
}

} // namespace

bool isHostReadable(const void* address, uint64_t bytes) {
    return isHostMemory(address, bytes, false);
}

bool isHostWritable(void* address, uint64_t bytes) {
    return isHostMemory(address, bytes, true);
}

} // namespace sunstone::engine
