// SPDX-License-Identifier: Apache-2.0
// See forked.h.
#include "base/forked.h"

#include "base/log.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <mutex>
#include <string_view>

namespace sunstone {
namespace {

std::atomic<bool> isChild{false};

// Without the lock of the log: see refusesForkedChild().
void explainOnce() {
    static std::atomic<bool> told{false};
    if (told.exchange(true) || !logEnabled(LogLevel::kFatal, "base"))
        return;
    constexpr std::string_view kText =
        "[sunstone base fatal] this process is a child, by fork, of one that had initialised CUDA "
        "or OptiX: its calls fail; call exec in the child, or fork before the first call\n";
    if (write(STDERR_FILENO, kText.data(), kText.size()) < 0)
        return; // nothing else to do
}

} // namespace

void watchForks() {
    static std::once_flag once;
    std::call_once(once, [] {
        logEnabled(LogLevel::kFatal, "base"); // reads the settings, which explainOnce() must not
        pthread_atfork(nullptr, nullptr, [] { isChild = true; });
    });
}

bool isForkedChild() {
    return isChild.load(std::memory_order_relaxed);
}

bool refusesForkedChild() {
    if (!isForkedChild())
        return false;
    explainOnce();
    return true;
}

} // namespace sunstone
