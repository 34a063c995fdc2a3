// SPDX-License-Identifier: Apache-2.0
// Worker threads of the process: launches, kernels and builds share one oneTBB arena with the
// number of threads of cpu_limits.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace sunstone {

unsigned threadCount();

// Runs body(begin, end) over [0, count) in pieces of at least `grain` on the shared threads and
// waits. Rethrows the first exception that a body throws.
void parallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body);

// Starts the shared threads, if they are not running. Code that may run during process exit must
// call this earlier: oneTBB's static objects are destroyed at exit, except those in use.
void startArena();

// The calling thread's stack, from its lowest address to its end; empty if it is unknown.
struct StackBounds {
    uintptr_t begin = 0, end = 0;
};
StackBounds stackOfThread();

// Runs body inside the shared arena, so that oneTBB algorithms in it use the shared threads.
void inArena(const std::function<void()>& body);

} // namespace sunstone
