// SPDX-License-Identifier: Apache-2.0
// See threads.h.
#include "base/threads/threads.h"

#include "base/float_mode.h"
#include "base/threads/cpu_limits.h"
#include "base/threads/thread_team.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

// The library behind inArena is not built with the thread sanitizer. The sanitizer therefore cannot
// see that its tasks start after the call that makes them and end before it returns.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#include <sanitizer/tsan_interface.h>
#define SUNSTONE_HAPPENS_BEFORE(address) __tsan_release(address)
#define SUNSTONE_HAPPENS_AFTER(address) __tsan_acquire(address)
#define SUNSTONE_NOT_SANITIZED __attribute__((no_sanitize("thread")))
#endif
#endif
#ifndef SUNSTONE_HAPPENS_BEFORE
#define SUNSTONE_NOT_SANITIZED
#define SUNSTONE_HAPPENS_BEFORE(address) (void)(address)
#define SUNSTONE_HAPPENS_AFTER(address) (void)(address)
#endif

namespace sunstone {
namespace {

// Device programs recurse: each level of optixTrace takes a few kilobytes of stack.
constexpr size_t kWorkerStackBytes = size_t(16) << 20;

struct Workers {
    Workers() {
        // oneTBB warns of arenas beyond its own limit. Setting a lower limit would also limit the
        // application.
        if (threadCount() > unsigned(tbb::info::default_concurrency()))
            raised.emplace(tbb::global_control::max_allowed_parallelism, threadCount());
    }
    std::optional<tbb::global_control> raised;
    tbb::global_control stack{tbb::global_control::thread_stack_size, kWorkerStackBytes};
    tbb::task_arena arena{int(threadCount())};
};

Workers& workers() {
    // Never destroyed: streams may still run work while the process exits.
    static Workers* instance = new Workers;
    return *instance;
}

// The team that the calling thread runs in, or null.
thread_local ThreadTeam* team = nullptr;

} // namespace

struct ThreadTeam::Arena {
    explicit Arena(unsigned threads) : arena(int(threads)) {}
    tbb::task_arena arena;
};

ThreadTeam::ThreadTeam(unsigned threads)
    : threads_(std::clamp(threads, 1u, threadCount())),
      arena_((workers(), std::make_unique<Arena>(threads_))) {}

ThreadTeam::~ThreadTeam() = default;

void ThreadTeam::run(const std::function<void()>& body) {
    struct Scope {
        explicit Scope(ThreadTeam* mine) : before(team) { team = mine; }
        ~Scope() { team = before; }
        ThreadTeam* before;
    } scope(this);
    body();
}

unsigned threadCount() {
    return cpuLimit().threads;
}

StackBounds stackOfThread() {
    thread_local const StackBounds bounds = [] {
        pthread_attr_t attributes;
        void* lowest = nullptr;
        size_t size = 0;
        if (pthread_getattr_np(pthread_self(), &attributes) != 0)
            return StackBounds{};
        pthread_attr_getstack(&attributes, &lowest, &size);
        pthread_attr_destroy(&attributes);
        const auto begin = reinterpret_cast<uintptr_t>(lowest);
        return StackBounds{begin, begin + size};
    }();
    return bounds;
}

// The threads of an arena work in the mode in which its first call is made.
void startArena() {
    const DeviceFloatMode mode;
    workers().arena.initialize();
}

// If the arena is full, one of its threads runs the body.
void inArena(const std::function<void()>& body) {
    const DeviceFloatMode mode;
    char handOff = 0; // an address for the sanitizer
    SUNSTONE_HAPPENS_BEFORE(&handOff);
    tbb::task_arena& arena = team ? team->arena_->arena : workers().arena;
    arena.execute([&]() SUNSTONE_NOT_SANITIZED {
        SUNSTONE_HAPPENS_AFTER(&handOff);
        body();
        SUNSTONE_HAPPENS_BEFORE(&handOff);
    });
    SUNSTONE_HAPPENS_AFTER(&handOff);
}

// Hands out pieces that get smaller towards the end, because costs per item are unknown and uneven
// (rows of sky, then rows of forest): no thread waits long for another's last piece.
void parallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) {
    if (count == 0)
        return;
    constexpr size_t kPiecesPerThread = 8;
    grain = std::max<size_t>(grain, 1);
    std::atomic<size_t> next{0};
    char tasks = 0; // an address for the sanitizer
    const auto work = [&] {
        size_t begin = next.load(std::memory_order_relaxed);
        while (begin < count) {
            const size_t rest = count - begin;
            const size_t piece = std::max(grain, rest / (kPiecesPerThread * threadCount()));
            const size_t end = begin + std::min(rest, piece);
            if (!next.compare_exchange_weak(begin, end, std::memory_order_relaxed))
                continue;
            try {
                body(begin, end);
            } catch (...) {
                next = count; // no thread starts another piece
                SUNSTONE_HAPPENS_BEFORE(&tasks);
                throw;
            }
            begin = next.load(std::memory_order_relaxed);
        }
        SUNSTONE_HAPPENS_BEFORE(&tasks);
    };
    const size_t threads =
        std::min<size_t>(team ? team->threads_ : threadCount(), (count - 1) / grain + 1);
    SUNSTONE_HAPPENS_BEFORE(&tasks);
    inArena([&] {
        tbb::parallel_for(
            tbb::blocked_range<size_t>(0, threads, 1),
            // Reads captured variables before the sanitizer knows that they may be read.
            [&](const tbb::blocked_range<size_t>& range) SUNSTONE_NOT_SANITIZED {
                SUNSTONE_HAPPENS_AFTER(&tasks);
                for (size_t i = range.begin(); i != range.end(); ++i)
                    work();
            },
            tbb::simple_partitioner());
    });
    SUNSTONE_HAPPENS_AFTER(&tasks);
}

} // namespace sunstone
