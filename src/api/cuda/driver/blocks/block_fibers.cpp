// SPDX-License-Identifier: Apache-2.0
// Threads of a block as fibers.
//
// Each thread has a state: ready, waiting (at a barrier, in an exchange of its warp, for its active
// mask) or done. The scheduler resumes ready threads in order. The last thread to reach a meeting
// point completes it. The end of a thread may complete one as well, because barriers and exchanges
// count only live threads.
//
// activeMask waits for no partners: when no thread is ready, it returns all lanes of the warp that
// wait at the same instruction, which is the convergence that programs expect. A thread that keeps
// reading memory that others may write yields and stays ready. If all ready threads only yield, the
// block waits for other blocks or the host. If no thread is ready and threads remain, the kernel is
// deadlocked, and the launch fails instead of hanging.
#include "api/cuda/driver/blocks/block_fibers.h"

#include "base/error.h"
#include "base/threads/worker_object.h"

#include <algorithm>
#include <cstring>
#include <thread>

namespace sunstone::api::cuda {

using devlib::KernelThread;

namespace {

using Fibers = BlockRunner::Fibers;

// The block that the thread runs, for fibers that start.
Fibers*& currentBlock() {
    thread_local Fibers* block = nullptr;
    return block;
}

} // namespace

FiberStacks& threadStacks() {
    return workerObject<FiberStacks>();
}

struct FiberTable {
    static Fibers& of(KernelThread* thread) { return *static_cast<Fibers*>(thread->block); }
    static uint32_t barrier(KernelThread* t, uint32_t id, uint32_t threads, uint32_t reduction,
                            uint32_t value) {
        return of(t).barrier(t, id, threads, reduction, value);
    }
    static void arrive(KernelThread* t, uint32_t id, uint32_t threads) {
        of(t).arrive(id, threads);
    }
    static uint32_t exchange(KernelThread* t, uint32_t mask, uint64_t value, uint64_t values[32]) {
        return of(t).exchange(t, mask, value, values);
    }
    static uint32_t activeMask(KernelThread* t, const void* site) {
        return of(t).activeMask(t, site);
    }
    static void exitThread(KernelThread* t) { of(t).leave(t); }
    static void fault(KernelThread* t, uint32_t kind) { of(t).fault(t, kind); }
    static void yield(KernelThread* t) { of(t).yield(t); }
    static void checkMemory(KernelThread* t, const devlib::CheckedAccess* access) {
        of(t).checkMemory(t, *access);
    }
    static uint64_t stackEnd(KernelThread* t) { return of(t).stackEnd(t); }
    static constexpr devlib::BlockFunctions kFunctions = {
        barrier, arrive, exchange, activeMask, exitThread, fault, yield, checkMemory, stackEnd};
};

BlockRunner::Fibers::Fibers(Launch& launch, FiberStacks& stacks)
    : functions_(&FiberTable::kFunctions), launch_(launch), stacks_(stacks) {
    // For frames of compiled kernels, printf and the run-time's functions.
    constexpr size_t kBaseStack = 128 << 10;
    stacks_.reserve(launch.threadsPerBlock(), kBaseStack + launch.localBytes);
    fibers_.resize(launch.threadsPerBlock());
}

BlockRunner::Fibers::Fiber& BlockRunner::Fibers::fiberOf(KernelThread* thread) {
    return *reinterpret_cast<Fiber*>(thread); // the thread is a fiber's first member
}

void BlockRunner::Fibers::entry() {
    Fibers& self = *currentBlock();
    Fiber& fiber = *self.running_;
    self.sanitizer_.entered();
    self.launch_.kernel(&fiber.thread, self.launch_.params);
    self.leave(&fiber.thread);
}

void BlockRunner::Fibers::suspend(Fiber& fiber) {
    sanitizer_.leave(fiber.state == State::kDone);
    switchFiber(&fiber.context, scheduler_);
    sanitizer_.entered();
}

void BlockRunner::Fibers::resume(Fiber& fiber) {
    running_ = &fiber;
    const auto index = size_t(&fiber - fibers_.data());
    sanitizer_.enter(index, stacks_.top(index), stacks_.size());
    switchFiber(&scheduler_, fiber.context);
    sanitizer_.left();
}

void BlockRunner::Fibers::run(const KernelThread& prototype) {
    start(prototype);
    while (step() == Progress::kWaits)
        std::this_thread::yield();
}

void BlockRunner::Fibers::start(const KernelThread& prototype) {
    const uint32_t count = launch_.threadsPerBlock();
    for (uint32_t i = 0; i < count; ++i) {
        Fiber& fiber = fibers_[i];
        fiber.thread = prototype;
        fiber.thread.block = this;
        placeThread(fiber.thread, launch_, i);
        fiber.context = makeFiber(stacks_.top(i), &Fibers::entry);
        fiber.state = State::kReady;
    }
    barriers_ = {};
    live_ = ready_ = count;
    sanitizer_.restart(count);
}

Fibers::Progress BlockRunner::Fibers::step() {
    prepareForFaults();
    currentBlock() = this;
    sanitizer_.begin();
    if (setjmp(frame_.jump) == kJumpFault) { // the jump comes from a fiber's stack, which is
                                             // abandoned
        sanitizer_.abandoned();
        launch_.noteFault(frame_, running_->thread);
        return Progress::kDone;
    }
    // Once for all switches, because the scheduler in between owns nothing either.
    enterDeviceCode(frame_);
    const Progress progress = resumeAll();
    leaveDeviceCode();
    return progress;
}

Fibers::Progress BlockRunner::Fibers::resumeAll() {
    while (live_ != 0) {
        bool advanced = false;
        for (Fiber& fiber : fibers_) {
            if (fiber.state != State::kReady)
                continue;
            fiber.yielded = false;
            resume(fiber);
            advanced |= !fiber.yielded;
        }
        if (launch_.hasFailed())
            return Progress::kDone; // stacks are abandoned; compiled code owns nothing
        if (advanced && ready_ != 0)
            continue;
        if (live_ == 0 || resolveActive())
            continue;
        if (ready_ != 0)
            return Progress::kWaits;
        launch_.deadlock = true;
        return Progress::kDone;
    }
    return Progress::kDone;
}

void BlockRunner::Fibers::leave(KernelThread* thread) {
    Fiber& fiber = fiberOf(thread);
    fiber.state = State::kDone;
    --live_;
    --ready_;
    for (uint32_t id = 0; id < barriers_.size(); ++id)
        if (barriers_[id].isUsed())
            tryBarrier(id);
    tryExchange(thread->warpid);
    suspend(fiber); // never resumed
}

void BlockRunner::Fibers::fault(KernelThread* thread, uint32_t kind) {
    uint32_t none = 0;
    launch_.fault.compare_exchange_strong(none, 1 + kind);
    leave(thread);
}

void BlockRunner::Fibers::yield(KernelThread* thread) {
    Fiber& fiber = fiberOf(thread);
    thread->spins = kSpins;
    fiber.yielded = true;
    suspend(fiber);
}

void BlockRunner::Fibers::checkMemory(KernelThread* thread, const devlib::CheckedAccess& access) {
    if (const uint32_t kind = cuda::checkMemory(launch_, *thread, access, stackEnd(thread)))
        fault(thread, kind - 1);
}

uint64_t BlockRunner::Fibers::stackEnd(KernelThread* thread) {
    return reinterpret_cast<uint64_t>(stacks_.top(size_t(&fiberOf(thread) - fibers_.data())));
}

// ---- barriers ---------------------------------------------------------------------------------

uint32_t BlockRunner::Fibers::barrier(KernelThread* thread, uint32_t id, uint32_t threads,
                                      uint32_t reduction, uint32_t value) {
    id %= BlockBarrier::kCount;
    Fiber& fiber = fiberOf(thread);
    barriers_[id].wait(threads, reduction, value != 0);
    fiber.state = State::kBarrier;
    fiber.barrier = id;
    --ready_;
    tryBarrier(id);
    if (fiber.state != State::kReady)
        suspend(fiber);
    return fiber.result;
}

void BlockRunner::Fibers::arrive(uint32_t id, uint32_t threads) {
    id %= BlockBarrier::kCount;
    barriers_[id].arrive(threads);
    tryBarrier(id);
}

void BlockRunner::Fibers::tryBarrier(uint32_t id) {
    if (!barriers_[id].isComplete(live_))
        return;
    const uint32_t result = barriers_[id].result();
    barriers_[id] = {};
    for (Fiber& fiber : fibers_) {
        if (fiber.state != State::kBarrier || fiber.barrier != id)
            continue;
        fiber.result = result;
        fiber.state = State::kReady;
        ++ready_;
    }
}

// ---- warps ------------------------------------------------------------------------------------

uint32_t BlockRunner::Fibers::exchange(KernelThread* thread, uint32_t mask, uint64_t value,
                                       uint64_t values[32]) {
    Fiber& fiber = fiberOf(thread);
    fiber.state = State::kExchange;
    fiber.mask = mask | 1u << thread->laneid;
    fiber.value = value;
    fiber.values = values;
    --ready_;
    tryExchange(thread->warpid);
    if (fiber.state != State::kReady)
        suspend(fiber);
    return fiber.result;
}

// Completes every exchange of the warp whose lanes have all arrived.
void BlockRunner::Fibers::tryExchange(uint32_t warp) {
    const size_t first = size_t(warp) * 32, count = std::min<size_t>(32, fibers_.size() - first);
    Fiber* lanes = fibers_.data() + first;
    for (size_t leader = 0; leader < count; ++leader) {
        if (lanes[leader].state != State::kExchange)
            continue;
        const uint32_t mask = lanes[leader].mask;
        uint32_t present = 0;
        bool complete = true;
        for (size_t i = 0; i < count && complete; ++i) {
            if (!(mask >> i & 1) || lanes[i].state == State::kDone)
                continue;
            complete = lanes[i].state == State::kExchange && lanes[i].mask == mask;
            present |= 1u << i;
        }
        if (!complete)
            continue;
        for (size_t i = 0; i < count; ++i)
            if (mask >> i & 1 && lanes[i].state == State::kDone)
                launch_.namesEnded.store(true, std::memory_order_relaxed);
        uint64_t values[32] = {};
        for (size_t i = 0; i < count; ++i)
            if (present >> i & 1)
                values[i] = lanes[i].value;
        for (size_t i = 0; i < count; ++i) {
            if (!(present >> i & 1))
                continue;
            std::memcpy(lanes[i].values, values, sizeof values);
            lanes[i].result = present;
            lanes[i].state = State::kReady;
            ++ready_;
        }
    }
}

uint32_t BlockRunner::Fibers::activeMask(KernelThread* thread, const void* site) {
    Fiber& fiber = fiberOf(thread);
    fiber.state = State::kActive;
    fiber.site = site;
    --ready_;
    suspend(fiber);
    return fiber.result;
}

bool BlockRunner::Fibers::resolveActive() {
    bool any = false;
    for (size_t first = 0; first < fibers_.size(); first += 32) {
        const size_t end = std::min(first + 32, fibers_.size());
        for (size_t leader = first; leader < end; ++leader) {
            if (fibers_[leader].state != State::kActive)
                continue;
            const void* const site = fibers_[leader].site;
            uint32_t mask = 0;
            for (size_t i = leader; i < end; ++i)
                if (fibers_[i].state == State::kActive && fibers_[i].site == site)
                    mask |= 1u << (i - first);
            for (size_t i = leader; i < end; ++i)
                if (mask >> (i - first) & 1) {
                    fibers_[i].result = mask;
                    fibers_[i].state = State::kReady;
                    ++ready_;
                }
            any = true;
        }
    }
    return any;
}

} // namespace sunstone::api::cuda
