// SPDX-License-Identifier: Apache-2.0
// See in_flight.h. Fibers switch to one another directly; only the walk runs on the thread's own
// stack. No object with a destructor lives on a fiber: exceptions of device programs leave through
// longjmp, and faults abandon the fiber.
#include "engine/cpu/in_flight.h"

#include "base/error.h"
#include "base/threads/fiber_stacks.h"
#include "base/threads/fiber_switch.h"
#include "base/threads/sanitizer_fibers.h"
#include "base/threads/worker_object.h"

#include <bit>
#include <csetjmp>
#include <memory>

namespace sunstone::engine::cpu {
namespace {

using devlib::ProgramFn;
using devlib::RayState;
using devlib::ThreadState;

constexpr unsigned kFibers = 64; // a bit each

// Stack size of a fiber, as of worker threads. A page takes memory once it is written.
constexpr size_t kStack = 16 << 20;
// Room below the stack limit for functions of the run-time that do not check.
constexpr size_t kReserve = 384 << 10;
// Offsets of the fibers' frames: without them all frames compete for the same sets of the caches.
constexpr size_t kColour = 1088, kColours = 61;

// Enumerates the launch indices of some tiles in square blocks of kFibers, whose rays are more
// coherent than those of rows.
class Indices {
public:
    Indices(const Tiling& tiling, uint64_t first, uint64_t end)
        : tiling_(tiling), tile_(tiling, first), number_(first), end_(end) {
        startBlock(0, 0);
    }

    bool take(uint32_t index[3]) {
        if (column_ == width_) {
            column_ = 0;
            ++row_;
        }
        if (row_ == height_ && !nextBlock())
            return false;
        index[0] = tile_.x + x_ + column_++;
        index[1] = tile_.y + y_ + row_;
        index[2] = tile_.z;
        return true;
    }

private:
    static constexpr uint32_t kSide = 8;

    void startBlock(uint32_t x, uint32_t y) {
        x_ = x;
        y_ = y;
        width_ = tile_.height == 1 ? tile_.width : std::min(kSide, tile_.width - x);
        height_ = std::min(kSide, tile_.height - y);
        column_ = row_ = 0;
    }
    bool nextBlock() {
        if (x_ + width_ < tile_.width) {
            startBlock(x_ + width_, y_);
        } else if (y_ + height_ < tile_.height) {
            startBlock(0, y_ + height_);
        } else {
            if (++number_ >= end_)
                return false;
            tile_ = Tile(tiling_, number_);
            startBlock(0, 0);
        }
        return true;
    }

    const Tiling& tiling_;
    Tile tile_;
    uint64_t number_, end_;
    uint32_t x_ = 0, y_ = 0, width_ = 0, height_ = 0; // the block, in the tile
    uint32_t column_ = 0, row_ = 0;                   // in the block
};

class InFlight;

struct Fiber {
    ThreadState thread; // first member: RayState::thread is the fiber's address
    InFlight* group;
    FiberContext context;
    ProgramFn next; // to run for the ray that the fiber waited for, or null
};

class InFlight {
public:
    InFlight(Runner& runner, const InFlightLaunch& inFlight, const Indices& indices,
             FiberStacks& stacks)
        : runner_(runner), inFlight_(inFlight), indices_(indices), stacks_(stacks) {}

    void run();
    void wait(Fiber& fiber, RayState* ray);

private:
    static void entry();
    void start(Fiber& fiber);
    void runIndices(Fiber& fiber);
    void step();
    void resume(Fiber& fiber);
    void walk();
    void endFaulty();
    void leave(Fiber& fiber, bool forever);

    Runner& runner_;
    const InFlightLaunch& inFlight_;
    Indices indices_;
    FiberStacks& stacks_;
    FaultFrame faults_;
    SanitizerFibers sanitizer_;
    FiberContext scheduler_ = nullptr;
    Fiber* running_ = nullptr; // null while the scheduler runs
    // The fibers ready_[nextReady_] to ready_[readyCount_ - 1] are ready to run.
    unsigned readyCount_ = 0, nextReady_ = 0, waitingCount_ = 0;
    Fiber* ready_[kFibers];
    Fiber* waiting_[kFibers];
    RayState* rays_[kFibers]; // of waiting fibers
    ProgramFn next_[kFibers]; // of waiting fibers
    Fiber fibers_[kFibers];
};

// The group that the thread runs, for fibers that start.
InFlight*& currentGroup() {
    thread_local InFlight* group = nullptr;
    return group;
}

void InFlight::entry() {
    InFlight& self = *currentGroup();
    self.sanitizer_.entered();
    Fiber& fiber = *self.running_;
    self.runIndices(fiber);
    self.leave(fiber, true);
}

// The loop of Runner::run, on a fiber. Faults of the processor go to the scheduler.
void InFlight::runIndices(Fiber& fiber) {
    FaultFrame frame;
    RayState state;
    fiber.thread.exceptionFrame = &frame;
    runner_.prepare(state, fiber.thread, reinterpret_cast<uint64_t>(__builtin_frame_address(0)),
                    reinterpret_cast<uint64_t>(stacks_.top(size_t(&fiber - fibers_))) -
                        stacks_.size() + kReserve);
    state.launch = &inFlight_.launch;
    volatile bool ending = false; // an exception program may raise exceptions itself
    if (setjmp(frame.jump) != 0) {
        leaveDeviceCode();
        if (!ending) {
            ending = true;
            runner_.endIndex(state, frame, faults_);
        }
        ending = false;
        enterDeviceCode(faults_);
    }
    while (indices_.take(fiber.thread.index))
        runner_.runEntry(state);
}

void InFlight::start(Fiber& fiber) {
    const size_t number = size_t(&fiber - fibers_);
    const size_t colour = number * kColour % (kColour * kColours) & ~size_t(15);
    fiber.thread = {};
    fiber.group = this;
    fiber.context = makeFiber(static_cast<char*>(stacks_.top(number)) - colour, &InFlight::entry);
    ready_[readyCount_++] = &fiber;
}

// Suspends the fiber, or ends it with `forever`; resumes the next ready fiber or the scheduler.
SUNSTONE_INLINE_MEMBER void InFlight::leave(Fiber& fiber, bool forever) {
    Fiber* next = nullptr;
    if (!SanitizerFibers::kActive && nextReady_ < readyCount_)
        next = ready_[nextReady_++];
    running_ = next;
    sanitizer_.leave(forever);
    switchFiber(&fiber.context, next ? next->context : scheduler_);
    sanitizer_.entered();
}

SUNSTONE_INLINE_MEMBER void InFlight::wait(Fiber& fiber, RayState* ray) {
    waiting_[waitingCount_] = &fiber;
    rays_[waitingCount_++] = ray;
    leave(fiber, false);
}

void InFlight::resume(Fiber& fiber) {
    running_ = &fiber;
    const auto number = size_t(&fiber - fibers_);
    sanitizer_.enter(number, stacks_.top(number), stacks_.size());
    switchFiber(&scheduler_, fiber.context);
    sanitizer_.left();
}

// Fibers with the same program run one after another, while its code is in the caches.
void InFlight::walk() {
    inFlight_.traceBatch(rays_, next_, waitingCount_);
    unsigned count = 0;
    for (uint64_t left = ~uint64_t(0) >> (64 - waitingCount_); left != 0;) {
        const ProgramFn program = next_[std::countr_zero(left)];
        for (uint64_t rest = left; rest != 0; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            if (next_[i] != program)
                continue;
            waiting_[i]->next = program;
            ready_[count++] = waiting_[i];
            left &= ~(uint64_t(1) << i);
        }
    }
    readyCount_ = count;
    nextReady_ = waitingCount_ = 0;
}

void InFlight::step() {
    for (;;) {
        while (nextReady_ < readyCount_)
            resume(*ready_[nextReady_++]);
        if (waitingCount_ == 0)
            return;
        walk();
    }
}

// After a processor fault its fiber, or all fibers whose rays were walked, continue with new
// indices.
void InFlight::endFaulty() {
    sanitizer_.abandoned();
    Fiber* const faulty = running_;
    const unsigned walked = faulty ? 0 : waitingCount_;
    runner_.noteFault(faults_, faulty ? faulty->thread : waiting_[0]->thread);
    // The remaining ready fibers move to the front, because `start` appends.
    const unsigned left = readyCount_ - nextReady_;
    for (unsigned i = 0; i < left; ++i)
        ready_[i] = ready_[nextReady_ + i];
    nextReady_ = 0;
    readyCount_ = left;
    if (faulty)
        start(*faulty);
    for (unsigned i = 0; i < walked; ++i)
        start(*waiting_[i]);
    if (!faulty)
        waitingCount_ = 0;
}

void InFlight::run() {
    currentGroup() = this;
    sanitizer_.restart(kFibers);
    sanitizer_.begin();
    for (Fiber& fiber : fibers_)
        start(fiber);
    if (setjmp(faults_.jump) == kJumpFault)
        endFaulty();
    running_ = nullptr;
    enterDeviceCode(faults_);
    step();
    leaveDeviceCode();
}

} // namespace

bool runInFlight(Runner& runner, const InFlightLaunch& inFlight, const Tiling& tiling,
                 uint64_t first, uint64_t end) {
    FiberStacks& stacks = workerObject<FiberStacks>();
    try {
        stacks.reserve(kFibers, kStack);
    } catch (const Error&) {
        return false;
    }
    const auto group =
        std::make_unique<InFlight>(runner, inFlight, Indices(tiling, first, end), stacks);
    group->run();
    return true;
}

void traceInFlight(RayState* ray) {
    auto& fiber = *reinterpret_cast<Fiber*>(ray->thread);
    fiber.group->wait(fiber, ray);
    if (fiber.next)
        fiber.next(ray);
}

} // namespace sunstone::engine::cpu
