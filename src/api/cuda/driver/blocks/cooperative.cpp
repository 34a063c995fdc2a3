// SPDX-License-Identifier: Apache-2.0
// See cooperative.h.
//
// If all threads of a block wait for other blocks (they keep reading some word, see
// KernelThread::spins), the worker sets the block aside and continues with the next one. One worker
// is therefore enough to complete a grid-wide barrier. All threads of a block must be able to stop
// anywhere: they run a warp at a time (block_lockstep.h), or every thread of the grid is a fiber.
// Blocks move between workers; a block never runs on two workers at once.
//
// A grid barrier in a program is a word in global memory that threads add to and poll. Programs
// provide the word, or use the one whose address %envreg1 and %envreg2 give.
#include "api/cuda/driver/blocks/cooperative.h"

#include "api/cuda/driver/blocks/block_fibers.h"
#include "api/cuda/driver/blocks/block_lockstep.h"
#include "base/threads/threads.h"

#include <deque>
#include <mutex>
#include <thread>

namespace sunstone::api::cuda {

namespace {

using Fibers = BlockRunner::Fibers;
using Lockstep = BlockRunner::Lockstep;

struct ResidentBlock {
    SharedMemory shared;
    FiberStacks stacks;
    std::unique_ptr<Fibers> fibers; // one of these two is set
    std::unique_ptr<Lockstep> warps;

    // True if the block waits, false if it is done.
    bool step() {
        if (fibers)
            return fibers->step() == Fibers::Progress::kWaits;
        Lockstep::Progress progress;
        do
            progress = warps->step();
        while (progress == Lockstep::Progress::kPaused);
        return progress == Lockstep::Progress::kWaits;
    }
};

class Grid {
public:
    Grid(Launch& launch, size_t count) : launch_(launch), remaining_(count) {
        for (size_t i = 0; i < count; ++i)
            waiting_.push_back(i);
        blocks_.resize(count);
    }

    void work() {
        while (remaining_.load(std::memory_order_acquire) != 0) {
            size_t number = 0;
            if (!take(number)) {
                std::this_thread::yield(); // other workers run the rest
                continue;
            }
            std::unique_ptr<ResidentBlock>& block = blocks_[number];
            try {
                if (!block)
                    block = make(number);
            } catch (...) {
                remaining_.store(0, std::memory_order_release); // the other blocks would wait for
                                                                // it
                throw;
            }
            if (block->step()) {
                putAside(number);
            } else {
                block.reset();
                size_t left = remaining_.load(std::memory_order_relaxed);
                while (left != 0 && !remaining_.compare_exchange_weak(left, left - 1)) {
                }
            }
        }
    }

private:
    bool take(size_t& number) {
        std::lock_guard lock(mutex_);
        if (waiting_.empty())
            return false;
        number = waiting_.front();
        waiting_.pop_front();
        return true;
    }
    void putAside(size_t number) {
        std::lock_guard lock(mutex_);
        waiting_.push_back(number);
    }
    std::unique_ptr<ResidentBlock> make(size_t number) {
        auto block = std::make_unique<ResidentBlock>();
        const size_t width = launch_.grid[0], height = launch_.grid[1];
        uint8_t* shared = block->shared.reserve(sharedBytesOf(launch_));
        const devlib::KernelThread prototype =
            blockPrototype(launch_, uint32_t(number % width), uint32_t(number / width % height),
                           uint32_t(number / width / height), shared);
        if (launch_.lockstep) {
            block->warps = std::make_unique<Lockstep>(launch_);
            block->warps->start(launch_, prototype);
        } else {
            block->fibers = std::make_unique<Fibers>(launch_, block->stacks);
            block->fibers->start(prototype);
        }
        return block;
    }

    Launch& launch_;
    std::vector<std::unique_ptr<ResidentBlock>> blocks_;
    std::mutex mutex_;
    std::deque<size_t> waiting_; // numbers of blocks that no worker runs
    std::atomic<size_t> remaining_;
};

} // namespace

void runCooperative(Launch& launch) {
    alignas(64) uint32_t workspace[16] = {};
    launch.gridWorkspace = reinterpret_cast<uintptr_t>(workspace);
    const size_t count = size_t(launch.grid[0]) * launch.grid[1] * launch.grid[2];
    Grid grid(launch, count);
    const size_t workers = std::min<size_t>(threadCount(), count);
    parallelFor(workers, 1, [&](size_t, size_t) { grid.work(); });
}

} // namespace sunstone::api::cuda
