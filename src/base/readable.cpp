// SPDX-License-Identifier: Apache-2.0
// See readable.h. Source: Linux manual, process_vm_readv(2) and mincore(2).
#include "base/readable.h"

#include <sys/mman.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <iterator>

namespace sunstone {

namespace {
std::atomic<uint64_t> gEpoch{1};
}

void beginReadableEpoch() {
    gEpoch.fetch_add(1, std::memory_order_relaxed);
}

uint64_t readableEpoch() {
    return gEpoch.load(std::memory_order_relaxed);
}

bool isReadableNearby(const void* address, size_t size) {
    constexpr uintptr_t kPage = 4096; // the smallest page size of all machines
    // Pages by the low bits of their numbers. 0 marks a free slot.
    struct Known {
        uint64_t epoch = 0;
        uintptr_t pages[4096] = {};
    };
    thread_local Known known;
    const uintptr_t first = uintptr_t(address) / kPage;
    const uintptr_t offset = uintptr_t(address) % kPage;
    if (size == 0 || size > 2 * kPage)
        return isReadable(address, size);
    if (known.epoch != readableEpoch()) {
        std::fill(std::begin(known.pages), std::end(known.pages), 0);
        known.epoch = readableEpoch();
    }
    for (uintptr_t page = first; page <= first + (offset + size - 1) / kPage; ++page) {
        uintptr_t& slot = known.pages[page % std::size(known.pages)];
        if (slot == page && page != 0)
            continue;
        if (!isReadable(reinterpret_cast<const void*>(page * kPage), 1))
            return false;
        slot = page;
    }
    return true;
}

bool isReadable(const void* address, size_t size) {
    const uintptr_t page = uintptr_t(sysconf(_SC_PAGESIZE));
    uintptr_t at = uintptr_t(address);
    if (size == 0)
        size = 1;
    // No user memory lies at addresses above the user half.
    if (at < page || size > (uintptr_t(1) << 47) || at > (uintptr_t(1) << 47) - size)
        return false;
    const uintptr_t end = at + size;
    while (at < end) {
        const uintptr_t next = std::min(end, (at & ~(page - 1)) + page);
        char copy;
        const iovec to{&copy, 1}, from{reinterpret_cast<void*>(at), 1};
        if (process_vm_readv(getpid(), &to, 1, &from, 1, 0) != 1) {
            if (errno == EFAULT)
                return false;
            // process_vm_readv is forbidden, as in some containers. Fall back to a check that the
            // page is mapped.
            unsigned char resident;
            if (mincore(reinterpret_cast<void*>(at & ~(page - 1)), page, &resident) != 0)
                return false;
        }
        at = next;
    }
    return true;
}

} // namespace sunstone
