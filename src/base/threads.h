// SPDX-License-Identifier: Apache-2.0
// Worker threads of the process: one oneTBB arena of SUNSTONE_THREADS threads (all cores by
// default) that launches, kernels and builds share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace sunstone {

unsigned threadCount();

// Runs body(begin, end) over [0, count) in pieces of at least `grain` on the shared threads and
// waits. The first exception thrown by a body is rethrown here.
void parallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body);

// Starts the shared threads, unless they are. What may run while the process exits needs that before:
// static objects of oneTBB are destroyed then, but not what is in use.
void startArena();

// The calling thread's stack, from its lowest address to its end; empty if it is unknown.
struct StackBounds {
    uintptr_t begin = 0, end = 0;
};
StackBounds stackOfThread();

// Runs body inside the shared arena, so that oneTBB algorithms in it use the shared threads.
void inArena(const std::function<void()>& body);

} // namespace sunstone
