// SPDX-License-Identifier: Apache-2.0
#include "base/readable.h"

#include <sys/mman.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>

namespace sunstone {

bool isReadable(const void* address, size_t size) {
    const uintptr_t page = uintptr_t(sysconf(_SC_PAGESIZE));
    uintptr_t at = uintptr_t(address);
    if (size == 0)
        size = 1;
    // Addresses above the user half are no business of the system calls below.
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
            // Forbidden here, as in some containers: at least see whether the page is mapped.
            unsigned char resident;
            if (mincore(reinterpret_cast<void*>(at & ~(page - 1)), page, &resident) != 0)
                return false;
        }
        at = next;
    }
    return true;
}

} // namespace sunstone
