// SPDX-License-Identifier: Apache-2.0
// The threads of a block as fibers, for kernels in which they meet. See block_fibers.cpp.
#pragma once

#include "api/cuda/driver/blocks/block.h"
#include "api/cuda/driver/blocks/block_barrier.h"
#include "base/threads/fiber_stacks.h"
#include "base/threads/fiber_switch.h"
#include "base/threads/sanitizer_fibers.h"

#include <vector>

namespace sunstone::api::cuda {

// The stacks of the calling thread.
FiberStacks& threadStacks();

struct BlockRunner::Fibers {
    Fibers(Launch& launch, FiberStacks& stacks);
    // Runs all threads of a block; `prototype` has their shared properties.
    void run(const devlib::KernelThread& prototype);

    // The same in steps, each on any CPU thread: start, then step until it returns kDone.
    void start(const devlib::KernelThread& prototype);
    enum class Progress : uint8_t { kDone, kWaits }; // kWaits: for other blocks or the host
    Progress step();

    // ---- called on fibers, through BlockFunctions ----
    uint32_t barrier(devlib::KernelThread* thread, uint32_t id, uint32_t threads,
                     uint32_t reduction, uint32_t value);
    void arrive(uint32_t id, uint32_t threads);
    uint32_t exchange(devlib::KernelThread* thread, uint32_t mask, uint64_t value,
                      uint64_t values[32]);
    uint32_t activeMask(devlib::KernelThread* thread, const void* site);
    void leave(devlib::KernelThread* thread);
    void fault(devlib::KernelThread* thread, uint32_t kind);
    void yield(devlib::KernelThread* thread);
    void checkMemory(devlib::KernelThread* thread, const devlib::CheckedAccess& access);
    uint64_t stackEnd(devlib::KernelThread* thread);
    static void entry();

private:
    enum class State : uint8_t { kReady, kBarrier, kExchange, kActive, kDone };
    struct Fiber {
        devlib::KernelThread thread;
        FiberContext context;
        State state;
        bool yielded;     // only waited when it last ran
        uint32_t barrier; // the id it waits for
        uint32_t mask;    // of an exchange
        uint32_t result;
        uint64_t value;
        uint64_t* values;
        const void* site; // of an active mask
    };

    Fiber& fiberOf(devlib::KernelThread* thread);
    void suspend(Fiber& fiber);
    void resume(Fiber& fiber);
    Progress resumeAll();
    void tryBarrier(uint32_t id);
    void tryExchange(uint32_t warp);
    bool resolveActive();

    // First, so that KernelThread::block points to the table.
    [[maybe_unused]] const devlib::BlockFunctions* functions_;
    Launch& launch_;
    FiberStacks& stacks_;
    std::vector<Fiber> fibers_;
    std::array<BlockBarrier, BlockBarrier::kCount> barriers_;
    FaultFrame frame_;
    SanitizerFibers sanitizer_;
    Fiber* running_ = nullptr;
    uint32_t live_ = 0;
    uint32_t ready_ = 0;
    FiberContext scheduler_ = nullptr;
};

} // namespace sunstone::api::cuda
