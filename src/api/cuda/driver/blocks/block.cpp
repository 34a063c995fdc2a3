// SPDX-License-Identifier: Apache-2.0
// See block.h. Runs kernels without barriers and warp functions, and chooses how a block runs.
#include "api/cuda/driver/blocks/block.h"

#include "api/cuda/driver/blocks/block_fibers.h"
#include "api/cuda/driver/blocks/block_lockstep.h"
#include "base/error.h"
#include "base/threads/worker_object.h"
#include "check/memory_check.h"

#include <sys/mman.h>

#include <algorithm>
#include <csetjmp>
#include <thread>

namespace sunstone::api::cuda {

namespace {

// The target of KernelThread::block in a plain loop.
struct LoopBlock {
    const devlib::BlockFunctions* functions;
    Launch* launch;
    FaultFrame frame; // a thread that ends early jumps to it
};

LoopBlock& blockOf(devlib::KernelThread* thread) {
    return *static_cast<LoopBlock*>(thread->block);
}

// Ends all threads of the block, not one.
constexpr int kJumpStop = 3;
static_assert(kJumpStop != kJumpFault);

// The kernel does not call these functions, as the compiler has determined.
uint32_t loopBarrier(devlib::KernelThread* thread, uint32_t, uint32_t, uint32_t, uint32_t) {
    blockOf(thread).launch->deadlock = true;
    std::longjmp(blockOf(thread).frame.jump, 1);
}
void loopArrive(devlib::KernelThread*, uint32_t, uint32_t) {}
uint32_t loopExchange(devlib::KernelThread* thread, uint32_t, uint64_t value, uint64_t values[32]) {
    values[thread->laneid] = value;
    return 1u << thread->laneid;
}
uint32_t loopActiveMask(devlib::KernelThread* thread, const void*) {
    return 1u << thread->laneid;
}
void loopExit(devlib::KernelThread* thread) {
    std::longjmp(blockOf(thread).frame.jump, 1);
}
void loopFault(devlib::KernelThread* thread, uint32_t kind) {
    uint32_t none = 0;
    blockOf(thread).launch->fault.compare_exchange_strong(none, 1 + kind);
    std::longjmp(blockOf(thread).frame.jump, 1);
}

void loopYield(devlib::KernelThread* thread) {
    thread->spins = kSpins;                  // other blocks run on other threads
    if (blockOf(thread).launch->hasFailed()) // the thread may wait for one that failed
        std::longjmp(blockOf(thread).frame.jump, kJumpStop);
    std::this_thread::yield();
}
void loopCheck(devlib::KernelThread* thread, const devlib::CheckedAccess* access) {
    const uint64_t top = check::stackOfThread().end;
    if (const uint32_t fault = checkMemory(*blockOf(thread).launch, *thread, *access, top))
        loopFault(thread, fault - 1);
}

// Equals placeThread for the next thread, without divisions.
void nextThread(devlib::KernelThread& thread, const Launch& launch) {
    thread.spins = kSpins; // a single thread seldom reads that often
    thread.laneid = (thread.laneid + 1) % 32;
    thread.warpid += thread.laneid == 0;
    if (++thread.tid[0] != launch.block[0])
        return;
    thread.tid[0] = 0;
    if (++thread.tid[1] != launch.block[1])
        return;
    thread.tid[1] = 0;
    ++thread.tid[2];
}

uint64_t loopStackEnd(devlib::KernelThread*) {
    return check::stackOfThread().end;
}

constexpr devlib::BlockFunctions kLoopFunctions = {loopBarrier,    loopArrive, loopExchange,
                                                   loopActiveMask, loopExit,   loopFault,
                                                   loopYield,      loopCheck,  loopStackEnd};

// Shared memory for the blocks that a CPU thread runs one after another, kept for the next launch.
SharedMemory& threadShared() {
    return workerObject<SharedMemory>();
}

} // namespace

uint8_t* SharedMemory::reserve(size_t size) {
    if (size <= size_)
        return base_;
    drop();
    const size_t rounded = (size + 65535) & ~size_t(65535);
    void* memory = mmap(nullptr, rounded, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_32BIT, -1, 0);
    if (memory == MAP_FAILED)
        fail(Code::kOutOfMemory, "no memory below 4 GiB for ", size, " bytes of shared memory");
    base_ = static_cast<uint8_t*>(memory);
    size_ = rounded;
    return base_;
}

void SharedMemory::drop() {
    if (base_)
        munmap(base_, size_);
    base_ = nullptr;
    size_ = 0;
}

size_t sharedBytesOf(const Launch& launch) {
    // Dynamic shared memory starts at the next multiple of 16 after the static part.
    const size_t statics = launch.staticShared;
    return launch.dynamicShared ? (statics + 15) / 16 * 16 + launch.dynamicShared : statics;
}

devlib::KernelThread blockPrototype(const Launch& launch, uint32_t x, uint32_t y, uint32_t z,
                                    uint8_t* shared) {
    devlib::KernelThread thread{};
    for (int i = 0; i < 3; ++i) {
        thread.ntid[i] = launch.block[i];
        thread.nctaid[i] = launch.grid[i];
    }
    thread.ctaid[0] = x;
    thread.ctaid[1] = y;
    thread.ctaid[2] = z;
    thread.shared = shared;
    thread.sharedBytes = uint32_t(sharedBytesOf(launch));
    thread.dynamicSharedSize = launch.dynamicShared;
    thread.gridWorkspace = launch.gridWorkspace;
    thread.spins = kSpins;
    return thread;
}

uint32_t checkMemory(const Launch& launch, const devlib::KernelThread& thread,
                     const devlib::CheckedAccess& access, uint64_t stackTop) {
    constexpr uint64_t kWorkspace = 64; // see cooperative.cpp
    if (launch.cooperative &&
        check::Range{launch.gridWorkspace, launch.gridWorkspace + kWorkspace}.holds(
            access.address, access.place->bytes))
        return 0;
    check::Scene scene;
    scene.kernel = launch.name;
    std::copy_n(thread.ctaid, 3, scene.block);
    std::copy_n(thread.tid, 3, scene.thread);
    const auto shared = reinterpret_cast<uint64_t>(thread.shared);
    scene.shared = {shared, shared + sharedBytesOf(launch)};
    const auto params = reinterpret_cast<uint64_t>(launch.params);
    scene.params = {params, params + launch.paramBytes};
    scene.stack = {reinterpret_cast<uint64_t>(__builtin_frame_address(0)), stackTop};
    switch (check::examine(access, scene)) {
    case check::Fault::kNone:
        return 0;
    case check::Fault::kAddress:
        return 1 + devlib::kFaultAddress;
    case check::Fault::kAlignment:
        return 1 + devlib::kFaultAlignment;
    case check::Fault::kShared:
        return 1 + devlib::kFaultShared;
    }
    return 0;
}

void placeThread(devlib::KernelThread& thread, const Launch& launch, uint32_t index) {
    const auto& block = launch.block;
    thread.tid[0] = index % block[0];
    thread.tid[1] = index / block[0] % block[1];
    thread.tid[2] = index / block[0] / block[1];
    thread.laneid = index % 32;
    thread.warpid = index / 32;
}

BlockRunner::BlockRunner(Launch& launch) : launch_(launch) {
    prepareForFaults();
    constexpr size_t kAlignment = 1024; // the strictest alignment in kernels
    const size_t size = (sharedBytesOf(launch) + kAlignment - 1) / kAlignment * kAlignment;
    shared_ = size ? threadShared().reserve(launch.lockstep ? size * kSideBySide : size) : nullptr;
    if (launch.lockstep) {
        side_ = std::move(keptSide());
        for (size_t i = 0; i < kSideBySide; ++i)
            sideShared_[i] = shared_ ? shared_ + i * size : nullptr;
    } else if (launch.meets) {
        fibers_ = std::make_unique<Fibers>(launch, threadStacks());
    }
}

BlockRunner::~BlockRunner() {
    constexpr size_t kMostKept = size_t(1) << 18;
    for (size_t i = 0; i < side_.size(); ++i)
        if (side_[i] && side_[i]->bytes() <= kMostKept)
            keptSide()[i] = std::move(side_[i]);
}

BlockRunner::Side& BlockRunner::keptSide() {
    return workerObject<Side>();
}

devlib::KernelThread BlockRunner::prototypeOf(uint64_t block, uint8_t* shared) const {
    const uint64_t width = launch_.grid[0], height = launch_.grid[1];
    return blockPrototype(launch_, uint32_t(block % width), uint32_t(block / width % height),
                          uint32_t(block / width / height), shared);
}

void BlockRunner::run(uint64_t begin, uint64_t end) {
    if (launch_.lockstep)
        return runLockstep(begin, end);
    for (uint64_t i = begin; i < end && !launch_.stops(); ++i) {
        if (fibers_)
            fibers_->run(prototypeOf(i, shared_));
        else
            runLoop(i);
    }
}

void BlockRunner::runLoop(uint64_t number) {
    LoopBlock block{&kLoopFunctions, &launch_, {}};
    devlib::KernelThread thread = prototypeOf(number, shared_);
    thread.block = &block;
    const uint32_t count = launch_.threadsPerBlock();
    // A thread that ends early jumps to setjmp. Of the local variables that have changed since, the
    // jump keeps those in memory: `index`, which is volatile, and `thread` and `block`, the
    // addresses of which are known outside this function. `count` does not change.
    volatile uint32_t index = 0;
    const int reason = setjmp(block.frame.jump);
    if (reason == kJumpFault) {
        launch_.noteFault(block.frame, thread);
        return;
    }
    if (reason == kJumpStop) {
        leaveDeviceCode();
        return;
    }
    if (reason != 0)
        index = index + 1;
    enterDeviceCode(block.frame);
    placeThread(thread, launch_, index);
    while (index < count) {
        launch_.kernel(&thread, launch_.params);
        index = index + 1;
        nextThread(thread, launch_);
    }
    leaveDeviceCode();
}

} // namespace sunstone::api::cuda
