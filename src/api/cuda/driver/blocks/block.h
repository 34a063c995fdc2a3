// SPDX-License-Identifier: Apache-2.0
// Runs the blocks of a kernel launch on one thread of the processor. Kernels run in one of three
// ways:
//
// - kernels with code for a warp at a time: block_lockstep.cpp;
// - others without barriers and warp functions: a plain loop over the threads of a block;
// - others: each thread of the block is a fiber with its own stack (base/threads/fiber_switch.h). A
//   thread that waits switches to the scheduler, which resumes ready threads in turn:
//   block_fibers.cpp.
//
// Threads of a block never run concurrently, so its state needs no locks.
#pragma once

#include "base/faults.h"
#include "compiler/compiler.h"
#include "devlib/lockstep.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace sunstone::api::cuda {

// The properties of a launch.
struct LaunchPlan {
    devlib::KernelFn kernel = nullptr;
    const std::byte* params = nullptr;
    std::array<uint32_t, 3> grid{}, block{};
    uint32_t staticShared = 0;
    uint32_t dynamicShared = 0;
    uint32_t localBytes = 0;
    bool cooperative = false;              // all blocks resident: see cooperative.h
    bool meets = false;                    // uses barriers or warp functions
    devlib::LockstepFn lockstep = nullptr; // runs a warp at a time; null: use `kernel`
    uint32_t frameBytes = 0;               // of a warp, for `lockstep`
    bool needsThreads = false;             // lockstep needs LockstepWarp::threads for all lanes
    const char* name = "";
    std::atomic<uint32_t>* blockCost = nullptr; // of the function

    uint32_t paramBytes = 0;

    uint32_t threadsPerBlock() const { return block[0] * block[1] * block[2]; }
};

// One execution of a plan, shared by all CPU threads that run its blocks.
struct Launch : LaunchPlan {
    explicit Launch(const LaunchPlan& plan) : LaunchPlan(plan) {}

    uint64_t gridWorkspace = 0;     // KernelThread::gridWorkspace
    std::atomic<uint32_t> fault{0}; // 1 + devlib::KernelFault of the first failure
    std::atomic<bool> deadlock{false};
    std::atomic<bool> namesEnded{false}; // a warp function named lanes that had ended
    // Written by the one thread that set `fault` to kProcessorFault.
    FaultFrame processorFault;
    devlib::KernelThread faulted{};
    uint32_t faultedLanes = 1; // lanes that ran together, starting with `faulted`

    static constexpr uint32_t kProcessorFault = ~uint32_t(0);
    // Whether the remaining threads are abandoned. Not after errors that the memory checker found:
    // it continues to find more.
    bool stops() const {
        const uint32_t kind = fault.load(std::memory_order_relaxed);
        if (cooperative) // other threads may wait for the one that ended
            return kind != 0;
        return kind != 0 && (kind == kProcessorFault || kind <= 1 + devlib::kFaultAssertion);
    }
    bool hasFailed() const { return stops() || deadlock.load(std::memory_order_relaxed); }
    // Records that a thread of the kernel ended with a processor fault.
    void noteFault(const FaultFrame& frame, const devlib::KernelThread& thread,
                   uint32_t lanes = 1) {
        uint32_t none = 0;
        if (!fault.compare_exchange_strong(none, kProcessorFault))
            return;
        processorFault = frame;
        faulted = thread;
        faultedLanes = lanes;
    }
};

// Runs blocks one after another, on the CPU thread that made it.
class BlockRunner {
public:
    explicit BlockRunner(Launch& launch);
    ~BlockRunner();
    BlockRunner(const BlockRunner&) = delete;
    BlockRunner& operator=(const BlockRunner&) = delete;

    // Runs the blocks from `begin` to `end`, by number in the grid.
    void run(uint64_t begin, uint64_t end);

    struct Fibers;
    struct Lockstep;

private:
    static constexpr size_t kSideBySide = 4;

    devlib::KernelThread prototypeOf(uint64_t block, uint8_t* shared) const;
    void runLoop(uint64_t block);
    void runLockstep(uint64_t begin, uint64_t end);
    void startLockstep(size_t place, uint64_t block);

    Launch& launch_;
    uint8_t* shared_ = nullptr; // owned by the thread, see block.cpp
    std::unique_ptr<Fibers> fibers_;
    // Blocks that run side by side, and their parts of the shared memory; kept for the blocks that
    // follow.
    using Side = std::array<std::unique_ptr<Lockstep>, kSideBySide>;
    static Side& keptSide();
    Side side_;
    std::array<uint8_t*, kSideBySide> sideShared_{};
};

// Reads of memory that others may write before a thread yields.
constexpr uint32_t kSpins = 64;

// Shared memory of a block. PTX may keep shared addresses in 32-bit registers, so it lies in the
// low 4 GiB.
class SharedMemory {
public:
    SharedMemory() = default;
    SharedMemory(const SharedMemory&) = delete;
    SharedMemory& operator=(const SharedMemory&) = delete;
    ~SharedMemory() { drop(); }
    uint8_t* reserve(size_t size); // null for 0; throws kOutOfMemory

private:
    void drop();
    uint8_t* base_ = nullptr;
    size_t size_ = 0;
};

// Bytes of shared memory that a block of the launch needs.
size_t sharedBytesOf(const Launch& launch);
// The properties that the threads of a block share.
devlib::KernelThread blockPrototype(const Launch& launch, uint32_t x, uint32_t y, uint32_t z,
                                    uint8_t* shared);
// devlib::BlockFunctions::checkMemory without the bounds of the thread's stack; returns 0 or 1 +
// the devlib::KernelFault.
uint32_t checkMemory(const Launch& launch, const devlib::KernelThread& thread,
                     const devlib::CheckedAccess& access, uint64_t stackTop);

// Fills the members of `thread` that differ between threads of a block from the thread's number,
// which counts x fastest.
void placeThread(devlib::KernelThread& thread, const Launch& launch, uint32_t index);

} // namespace sunstone::api::cuda
