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
    thread_local uint64_t epoch = 0;
    thread_local uintptr_t known = 0;
    const uintptr_t page = uintptr_t(address) / kPage;
    const bool isInside = size != 0 && uintptr_t(address) % kPage <= kPage - std::min(size, kPage);
    if (isInside && size <= kPage && page == known && epoch == readableEpoch())
        return true;
    if (!isReadable(address, size))
        return false;
    known = page;
    epoch = readableEpoch();
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
            // process_vm_readv is forbidden, as in some containers. Fall back to whether the page
            // is mapped.
            unsigned char resident;
            if (mincore(reinterpret_cast<void*>(at & ~(page - 1)), page, &resident) != 0)
                return false;
        }
        at = next;
    }
    return true;
}

} // namespace sunstone
