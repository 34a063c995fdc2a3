// SPDX-License-Identifier: Apache-2.0
// See forked.h.
#include "base/forked.h"

#include "base/log.h"

#include <pthread.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <iterator>
#include <mutex>
#include <string_view>

namespace sunstone {
namespace {

std::atomic<bool> isChild{false};

// Logs without the lock of the log: see refusesForkedChild().
void explainOnce() {
    static std::atomic<bool> told{false};
    if (told.exchange(true) || !logEnabled(LogLevel::kFatal, "base"))
        return;
    const std::string_view parts[] = {"[sunstone base fatal] ", kForkedChildText, "\n"};
    iovec lines[std::size(parts)];
    for (size_t i = 0; i < std::size(parts); ++i)
        lines[i] = {const_cast<char*>(parts[i].data()), parts[i].size()};
    if (writev(STDERR_FILENO, lines, int(std::size(lines))) < 0)
        return; // no other output is possible
}

} // namespace

const char* const kForkedChildText =
    "this process is a child, by fork, of one that had used Sunstone's libraries: its calls fail; "
    "call exec in the child, or fork before the first call";

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
