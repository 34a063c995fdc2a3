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

constexpr uintptr_t kPage = 4096; // the smallest page size of all machines
constexpr uintptr_t kUserEnd = uintptr_t(1) << 47;

std::atomic<uint64_t> gEpoch{1};

// Pages that were found readable, by the low bits of their numbers. A word has the page in its low
// 36 bits and the epoch above them, so that threads share the table without a lock. The epoch's 28
// bits repeat after more pieces of work than processes do while a word stays in its place.
constexpr size_t kSlots = 65536;
std::atomic<uint64_t> gKnown[kSlots];

uint64_t wordOf(uintptr_t page, uint64_t epoch) {
    return epoch << 36 | page;
}

bool isKnown(uintptr_t page, uint64_t epoch) {
    return page < kUserEnd / kPage && // the bits of others would mix with the epoch's
           gKnown[page % kSlots].load(std::memory_order_relaxed) == wordOf(page, epoch);
}

void remember(uintptr_t page, uint64_t epoch) {
    gKnown[page % kSlots].store(wordOf(page, epoch), std::memory_order_relaxed);
}

constexpr size_t kBatch = 256;

// At most kBatch pages. The system call reads a byte of each page, up to one that is not readable.
void rememberBatch(const uintptr_t* pages, size_t count, uint64_t epoch) {
    char copies[kBatch];
    iovec from[kBatch];
    for (size_t i = 0; i < count; ++i)
        from[i] = {reinterpret_cast<void*>(pages[i] * kPage), 1};
    for (size_t at = 0; at < count; ++at) {
        const iovec to{copies, count - at};
        const ssize_t read = process_vm_readv(getpid(), &to, 1, from + at, count - at, 0);
        if (read < 0 && errno != EFAULT)
            return; // forbidden, so isReadable looks at the pages
        for (ssize_t i = 0; i < read; ++i)
            remember(pages[at++], epoch);
    }
}

} // namespace

void beginReadableEpoch() {
    gEpoch.fetch_add(1, std::memory_order_relaxed);
}

uint64_t readableEpoch() {
    return gEpoch.load(std::memory_order_relaxed);
}

bool isReadableNearby(const void* address, size_t size) {
    const uintptr_t first = uintptr_t(address) / kPage;
    const uintptr_t offset = uintptr_t(address) % kPage;
    if (size == 0 || size > 2 * kPage)
        return isReadable(address, size);
    const uint64_t epoch = readableEpoch();
    for (uintptr_t page = first; page <= first + (offset + size - 1) / kPage; ++page) {
        if (isKnown(page, epoch))
            continue;
        if (!isReadable(reinterpret_cast<const void*>(page * kPage), 1))
            return false;
        remember(page, epoch);
    }
    return true;
}

void rememberReadable(const uint64_t* addresses, size_t count) {
    const uint64_t epoch = readableEpoch();
    uintptr_t pages[kBatch];
    size_t batch = 0;
    for (size_t i = 0; i < count; ++i) {
        const uintptr_t page = addresses[i] / kPage;
        if (page == 0 || page >= kUserEnd / kPage || isKnown(page, epoch) ||
            (batch > 0 && pages[batch - 1] == page))
            continue;
        pages[batch++] = page;
        if (batch == kBatch) {
            rememberBatch(pages, batch, epoch);
            batch = 0;
        }
    }
    rememberBatch(pages, batch, epoch);
}

bool isReadable(const void* address, size_t size) {
    const uintptr_t page = uintptr_t(sysconf(_SC_PAGESIZE));
    uintptr_t at = uintptr_t(address);
    if (size == 0)
        size = 1;
    // No user memory lies at addresses above the user half.
    if (at < page || size > kUserEnd || at > kUserEnd - size)
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
