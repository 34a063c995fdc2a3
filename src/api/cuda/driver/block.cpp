// SPDX-License-Identifier: Apache-2.0
// See block.h: the plain loop.
#include "api/cuda/driver/block.h"

#include "api/cuda/driver/block_fibers.h"
#include "base/error.h"

#include <csetjmp>

namespace sunstone::api::cuda {

namespace {

// What KernelThread::block points to in a plain loop.
struct LoopBlock {
    const devlib::BlockFunctions* functions;
    Launch* launch;
    std::jmp_buf leave; // where a thread that ends early goes
};

LoopBlock& blockOf(devlib::KernelThread* thread) { return *static_cast<LoopBlock*>(thread->block); }

// The compiler said that the kernel does not use these.
uint32_t loopBarrier(devlib::KernelThread* thread, uint32_t, uint32_t, uint32_t, uint32_t) {
    blockOf(thread).launch->deadlock = true;
    std::longjmp(blockOf(thread).leave, 1);
}
void loopArrive(devlib::KernelThread*, uint32_t, uint32_t) {}
uint32_t loopExchange(devlib::KernelThread* thread, uint32_t, uint64_t value, uint64_t values[32]) {
    values[thread->laneid] = value;
    return 1u << thread->laneid;
}
uint32_t loopActiveMask(devlib::KernelThread* thread) { return 1u << thread->laneid; }
void loopExit(devlib::KernelThread* thread) { std::longjmp(blockOf(thread).leave, 1); }
void loopFault(devlib::KernelThread* thread, uint32_t kind) {
    uint32_t none = 0;
    blockOf(thread).launch->fault.compare_exchange_strong(none, 1 + kind);
    std::longjmp(blockOf(thread).leave, 1);
}

constexpr devlib::BlockFunctions kLoopFunctions = {
    loopBarrier, loopArrive, loopExchange, loopActiveMask, loopExit, loopFault};

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
    constexpr size_t kAlignment = 128;
    const size_t size = (size_t(launch.staticShared) + 15) / 16 * 16 + launch.dynamicShared;
    sharedStorage_.resize(size + kAlignment);
    const uintptr_t start = uintptr_t(sharedStorage_.data());
    shared_ = reinterpret_cast<uint8_t*>((start + kAlignment - 1) & ~(kAlignment - 1));
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
    if (setjmp(block.leave) != 0)
        index = index + 1;
    while (index < count) {
        placeThread(thread, launch_, index);
        launch_.kernel(&thread, launch_.params);
        index = index + 1;
    }
}

} // namespace sunstone::api::cuda
