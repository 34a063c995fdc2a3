// SPDX-License-Identifier: Apache-2.0
// See block.h: the plain loop.
#include "api/cuda/driver/block.h"

#include "api/cuda/driver/block_fibers.h"
#include "base/error.h"

#include <sys/mman.h>

#include <csetjmp>

namespace sunstone::api::cuda {

namespace {

// What KernelThread::block points to in a plain loop.
struct LoopBlock {
    const devlib::BlockFunctions* functions;
    Launch* launch;
    FaultFrame frame; // its jump is where a thread that ends early goes
};

LoopBlock& blockOf(devlib::KernelThread* thread) {
    return *static_cast<LoopBlock*>(thread->block);
}

// The compiler said that the kernel does not use these.
uint32_t loopBarrier(devlib::KernelThread* thread, uint32_t, uint32_t, uint32_t, uint32_t) {
    blockOf(thread).launch->deadlock = true;
    std::longjmp(blockOf(thread).frame.jump, 1);
}
void loopArrive(devlib::KernelThread*, uint32_t, uint32_t) {}
uint32_t loopExchange(devlib::KernelThread* thread, uint32_t, uint64_t value, uint64_t values[32]) {
    values[thread->laneid] = value;
    return 1u << thread->laneid;
}
uint32_t loopActiveMask(devlib::KernelThread* thread) {
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

constexpr devlib::BlockFunctions kLoopFunctions = {loopBarrier,    loopArrive, loopExchange,
                                                   loopActiveMask, loopExit,   loopFault};

// Shared memory of the blocks a thread runs, kept for the next launch. PTX holds shared addresses
// in 32-bit registers as readily as in 64-bit ones, so it lies in the low 4 GiB.
class SharedMemory {
public:
    ~SharedMemory() { drop(); }
    uint8_t* reserve(size_t size) {
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

private:
    void drop() {
        if (base_)
            munmap(base_, size_);
        base_ = nullptr;
        size_ = 0;
    }
    uint8_t* base_ = nullptr;
    size_t size_ = 0;
};

SharedMemory& threadShared() {
    thread_local SharedMemory memory;
    return memory;
}

} // namespace

void placeThread(devlib::KernelThread& thread, const Launch& launch, uint32_t index) {
    const auto& block = launch.block;
    thread.tid[0] = index % block[0];
    thread.tid[1] = index / block[0] % block[1];
    thread.tid[2] = index / block[0] / block[1];
    thread.laneid = index % 32;
    thread.warpid = index / 32;
}

BlockRunner::BlockRunner(Launch& launch) : launch_(launch) {
    // Dynamic shared memory starts at a multiple of 16 after the static one.
    const size_t size = (size_t(launch.staticShared) + 15) / 16 * 16 + launch.dynamicShared;
    shared_ = size ? threadShared().reserve(size) : nullptr;
    if (launch.meets)
        fibers_ = std::make_unique<Fibers>(launch);
}

BlockRunner::~BlockRunner() = default;

void BlockRunner::run(uint32_t x, uint32_t y, uint32_t z) {
    if (launch_.fault.load(std::memory_order_relaxed))
        return; // the launch has failed already
    if (!fibers_) {
        runLoop(x, y, z);
        return;
    }
    devlib::KernelThread prototype{};
    for (int i = 0; i < 3; ++i) {
        prototype.ntid[i] = launch_.block[i];
        prototype.nctaid[i] = launch_.grid[i];
    }
    prototype.ctaid[0] = x;
    prototype.ctaid[1] = y;
    prototype.ctaid[2] = z;
    prototype.shared = shared_;
    prototype.dynamicSharedSize = launch_.dynamicShared;
    fibers_->run(prototype);
}

void BlockRunner::runLoop(uint32_t x, uint32_t y, uint32_t z) {
    LoopBlock block{&kLoopFunctions, &launch_, {}};
    prepareForFaults();
    devlib::KernelThread thread{};
    for (int i = 0; i < 3; ++i) {
        thread.ntid[i] = launch_.block[i];
        thread.nctaid[i] = launch_.grid[i];
    }
    thread.ctaid[0] = x;
    thread.ctaid[1] = y;
    thread.ctaid[2] = z;
    thread.shared = shared_;
    thread.dynamicSharedSize = launch_.dynamicShared;
    thread.block = &block;
    const uint32_t count = launch_.threadsPerBlock();
    // Volatile: it must keep its value over the jump.
    volatile uint32_t index = 0;
    const int reason = setjmp(block.frame.jump);
    if (reason == kJumpFault) {
        launch_.noteFault(block.frame, thread);
        return;
    }
    if (reason != 0)
        index = index + 1;
    enterDeviceCode(block.frame);
    while (index < count) {
        placeThread(thread, launch_, index);
        launch_.kernel(&thread, launch_.params);
        index = index + 1;
    }
    leaveDeviceCode();
}

} // namespace sunstone::api::cuda
