// SPDX-License-Identifier: Apache-2.0
// See process_end.h.
#include "base/process_end.h"

#include <link.h>

#include <atomic>
#include <cstdlib>

namespace sunstone {
namespace {

std::atomic<bool> ends{false};

// Number of libraries loaded so far.
unsigned long long librariesLoaded() {
    unsigned long long count = 0;
    dl_iterate_phdr(
        [](dl_phdr_info* info, size_t, void* result) {
            *static_cast<unsigned long long*>(result) = info->dlpi_adds;
            return 1;
        },
        &count);
    return count;
}

} // namespace

void watchProcessEnd() {
    // Register again if libraries were loaded since: they may have registered handlers.
    static std::atomic<unsigned long long> watched{0};
    const unsigned long long loaded = librariesLoaded();
    if (watched.exchange(loaded) != loaded)
        std::atexit([] { ends = true; });
}

bool processEnds() {
    return ends.load(std::memory_order_relaxed);
}

} // namespace sunstone
