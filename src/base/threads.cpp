// SPDX-License-Identifier: Apache-2.0
#include "base/threads.h"

#include "base/config.h"

#include <thread>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace sunstone {
namespace {

// Device programs recurse: each level of optixTrace takes a few kilobytes of stack.
constexpr size_t kWorkerStackBytes = size_t(16) << 20;

struct Workers {
    tbb::global_control stack{tbb::global_control::thread_stack_size, kWorkerStackBytes};
    tbb::task_arena arena{int(threadCount())};
};

Workers& workers() {
    // Never destroyed: streams may still run work while the process exits.
    static Workers* instance = new Workers;
    return *instance;
}

} // namespace

unsigned threadCount() {
    static const unsigned count = [] {
        unsigned cores = std::thread::hardware_concurrency();
        return configNumber(Setting::kThreads, cores ? cores : 1);
    }();
    return count;
}

void inArena(const std::function<void()>& body) {
    workers().arena.execute(body);
}

void parallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) {
    if (count == 0)
        return;
    inArena([&] {
        tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                          [&](const tbb::blocked_range<size_t>& range) {
                              body(range.begin(), range.end());
                          });
    });
}

} // namespace sunstone
