// SPDX-License-Identifier: Apache-2.0
// Runs the threads of a block a warp at a time (devlib/lockstep.h).
//
// While all warps take the same path, a block runs in rounds (runTogether): each warp runs to the
// next barrier of the whole block, which all of its lanes reach together, and single threads need
// no state. When lanes reach different points, or a point other than such a barrier, the block runs
// apart: each lane is ready, or waits at a barrier or for lanes of its warp, or has ended. Lanes of
// a warp that are ready at the same point run together. Barriers and exchanges follow the rules of
// block_fibers.cpp. Rounds resume when all lanes have reached a barrier, those of each warp at one
// point.
//
// Blocks run in steps, so that several can run side by side (runLockstep).
#include "api/cuda/driver/blocks/block_lockstep.h"

#include "compiler/lockstep/warp_functions.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <thread>

namespace sunstone::api::cuda {

using devlib::KernelThread;
using devlib::LockstepWarp;

namespace {

using Lockstep = BlockRunner::Lockstep;

constexpr uint32_t kPointMask = (1u << devlib::kPointBits) - 1;

uint32_t kindOf(uint32_t what) {
    return what >> devlib::kPointBits & 0xff;
}
uint32_t modeOf(uint32_t what) {
    return what >> devlib::kModeShift;
}

// The lanes of the mask whose word equals `word`.
uint32_t lanesWith(const uint32_t (&words)[devlib::kWarpLanes], uint32_t word, uint32_t mask) {
    uint32_t lanes = 0;
    for (uint32_t lane = 0; lane < devlib::kWarpLanes; ++lane)
        lanes |= uint32_t(((words[lane] ^ word) & mask) == 0) << lane;
    return lanes;
}

struct LockstepTable {
    static Lockstep& of(KernelThread* thread) { return *static_cast<Lockstep*>(thread->block); }
    static void arrive(KernelThread* t, uint32_t id, uint32_t threads) {
        of(t).arrive(id, threads);
    }
    // The code itself ends the lane.
    static void exitThread(KernelThread*) {}
    static void fault(KernelThread* t, uint32_t kind) { of(t).fault(kind); }
    // The code yields at its next pause.
    static void yield(KernelThread*) {}
    // Compiled code of this form never calls the others.
    static constexpr devlib::BlockFunctions kFunctions = {
        nullptr, arrive, nullptr, nullptr, exitThread, fault, yield, nullptr, nullptr};
};

} // namespace

BlockRunner::Lockstep::Lockstep(const Launch& launch)
    : functions_(&LockstepTable::kFunctions), shape_(launch.block), frameBytes_(launch.frameBytes),
      threadsPerWarp_(launch.needsThreads ? kLanes : 1) {
    const uint32_t count = launch.threadsPerBlock();
    const size_t warps = (count + kLanes - 1) / kLanes;
    warps_.resize(warps);
    states_.resize(warps);
    threads_.resize(warps * threadsPerWarp_);
    constexpr size_t kAlignment = 64;
    frames_.resize(warps * frameBytes_ + kAlignment);
    const size_t misplaced = reinterpret_cast<uintptr_t>(frames_.data()) % kAlignment;
    uint8_t* frames = frames_.data() + (kAlignment - misplaced) % kAlignment;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t lane = i % kLanes;
        LockstepWarp& warp = warps_[i / kLanes];
        KernelThread place{};
        placeThread(place, launch, i);
        for (size_t axis = 0; axis < 3; ++axis)
            warp.tid[axis][lane] = place.tid[axis];
        warp.laneid[lane] = lane;
        warp.all |= 1u << lane;
    }
    for (size_t i = 0; i < warps; ++i) {
        warps_[i].threads = threads_.data() + i * threadsPerWarp_;
        warps_[i].frame = frames + i * frameBytes_;
    }
}

bool BlockRunner::Lockstep::fits(const Launch& launch) const {
    return shape_ == launch.block && frameBytes_ == launch.frameBytes &&
           threadsPerWarp_ == (launch.needsThreads ? kLanes : 1);
}

size_t BlockRunner::Lockstep::bytes() const {
    return warps_.size() * sizeof(LockstepWarp) + threads_.size() * sizeof(KernelThread) +
           frames_.size();
}

constexpr uint32_t kNoBarrier = ~uint32_t(0);

// Blocks of one launch differ only in their index and their shared memory.
void BlockRunner::Lockstep::describeThreads(const KernelThread& prototype) {
    KernelThread alike = prototype_;
    std::copy_n(prototype.ctaid, 3, alike.ctaid);
    alike.shared = prototype.shared;
    const bool isKnown = std::memcmp(&alike, &prototype, sizeof alike) == 0;
    prototype_ = prototype;
    KernelThread* thread = threads_.data();
    for (uint32_t warp = 0; warp < warps_.size(); ++warp)
        for (uint32_t lane = 0; lane < threadsPerWarp_; ++lane, ++thread) {
            if (isKnown) {
                std::copy_n(prototype.ctaid, 3, thread->ctaid);
                thread->shared = prototype.shared;
                continue;
            }
            *thread = prototype;
            thread->block = this;
            for (size_t axis = 0; axis < 3; ++axis)
                thread->tid[axis] = warps_[warp].tid[axis][lane];
            thread->laneid = lane;
            thread->warpid = warp;
        }
}

void BlockRunner::Lockstep::start(Launch& launch, const KernelThread& prototype) {
    launch_ = &launch;
    describeThreads(prototype);
    barrier_ = kNoBarrier;
    live_ = launch.threadsPerBlock();
    for (size_t i = 0; i < warps_.size(); ++i) {
        warps_[i].live = warps_[i].all;
        warps_[i].namedEnded = 0;
        warps_[i].stopPoint = 0;
        states_[i].isAtBarrier = false;
    }
    if (isApart_)
        barriers_ = {};
    isApart_ = mayJoin_ = false;
}

BlockRunner::Lockstep::Progress BlockRunner::Lockstep::step() {
    if (setjmp(frame_.jump) == kJumpFault) {
        KernelThread thread = prototype_;
        const auto first = uint32_t(std::countr_zero(runningLanes_));
        const uint32_t last = kLanes - 1 - uint32_t(std::countl_zero(runningLanes_));
        placeThread(thread, *launch_, uint32_t(runningWarp_) * kLanes + first);
        launch_->noteFault(frame_, thread, last - first + 1);
        return Progress::kDone;
    }
    enterDeviceCode(frame_);
    const Progress progress = advance();
    leaveDeviceCode();
    return progress;
}

BlockRunner::Lockstep::Progress BlockRunner::Lockstep::advance() {
    while (live_ != 0) {
        const Progress progress = isApart_ ? runApart() : runTogether();
        if (progress != Progress::kGoesOn)
            return progress;
    }
    for (const LockstepWarp& warp : warps_)
        if (warp.namedEnded)
            launch_->namesEnded.store(true, std::memory_order_relaxed);
    return Progress::kDone;
}

uint32_t BlockRunner::Lockstep::runLanes(size_t index, uint32_t point, uint32_t lanes) {
    LockstepWarp& warp = warps_[index];
    runningWarp_ = index;
    runningLanes_ = lanes;
    warp.stops = 0;
    const uint32_t before = warp.live;
    const uint32_t ran = launch_->lockstep(&warp, launch_->params, point, lanes);
    live_ -= uint32_t(std::popcount(before & ~warp.live));
    if (isApart_)
        notePause(warp);
    return ran;
}

// Lanes at a pause record it once for the warp: copies it to each lane.
void BlockRunner::Lockstep::notePause(LockstepWarp& warp) {
    const uint32_t what = warp.stopPoint;
    if (warp.stops != 0 && kindOf(what) == devlib::kMeetPause && modeOf(what) == 0)
        std::fill(std::begin(warp.point), std::end(warp.point), what);
}

// ---- rounds -----------------------------------------------------------------------------------

// A round: runs each warp to its next stop.
BlockRunner::Lockstep::Progress BlockRunner::Lockstep::runTogether() {
    bool anyRan = false, advanced = false, paused = false;
    for (size_t i = 0; i < warps_.size(); ++i) {
        if (warps_[i].live == 0 || states_[i].isAtBarrier)
            continue;
        anyRan = true;
        if (!runWhole(i))
            return Progress::kGoesOn; // the block now runs apart
        if (launch_->hasFailed())
            return Progress::kDone;
        const uint32_t stop = warps_[i].stopPoint;
        const bool isPause = warps_[i].live != 0 && kindOf(stop) == devlib::kMeetPause;
        paused |= isPause;
        advanced |= !isPause || modeOf(stop) != 1;
    }
    if (anyRan)
        return !advanced ? Progress::kWaits : paused ? Progress::kPaused : Progress::kGoesOn;
    for (Warp& state : states_) // all have arrived
        state.isAtBarrier = false;
    barrier_ = kNoBarrier;
    return Progress::kGoesOn;
}

// Runs all lanes of a warp. False unless they stop together at a pause or at the barrier that the
// other warps have reached.
bool BlockRunner::Lockstep::runWhole(size_t index) {
    LockstepWarp& warp = warps_[index];
    const uint32_t lanes = warp.live, point = warp.stopPoint & kPointMask;
    const uint32_t ran = runLanes(index, point, lanes);
    if (launch_->hasFailed() || (warp.live == 0 && !isApart_))
        return true;
    const uint32_t kind = kindOf(warp.stopPoint), id = modeOf(warp.stopPoint);
    const bool isTogether =
        !isApart_ && ran == lanes && warp.stops == 1 && warp.stopLanes == warp.live;
    if (isTogether && kind == devlib::kMeetPause)
        return true;
    if (isTogether && kind == devlib::kMeetPlain && (barrier_ == kNoBarrier || barrier_ == id)) {
        states_[index].isAtBarrier = true;
        barrier_ = id;
        return true;
    }
    part(index);
    notePause(warp);
    if (const uint32_t rest = lanes & ~ran) {
        for (uint32_t bits = rest; bits != 0; bits &= bits - 1)
            warp.point[std::countr_zero(bits)] = point;
        states_[index].ready |= rest;
    }
    takeStops(index, ran & warp.live);
    return false;
}

// Switches to running apart, because this warp left the round: gives each lane the state of its
// warp.
void BlockRunner::Lockstep::part(size_t index) {
    isApart_ = true;
    for (Warp& state : states_) {
        state.ready = state.barrier = state.exchange = 0;
        std::memset(state.ids, 0, sizeof state.ids);
    }
    for (size_t i = 0; i < warps_.size(); ++i) {
        if (i == index)
            continue;
        LockstepWarp& warp = warps_[i];
        if (states_[i].isAtBarrier) {
            takeStops(i, warp.live);
            continue;
        }
        for (uint32_t& point : warp.point)
            point = warp.stopPoint & kPointMask;
        states_[i].ready |= warp.live;
    }
}

// ---- apart ------------------------------------------------------------------------------------

BlockRunner::Lockstep::Progress BlockRunner::Lockstep::runApart() {
    bool advanced = false, anyReady = false;
    for (size_t i = 0; i < warps_.size(); ++i) {
        if (mayJoin_ && join())
            return Progress::kGoesOn;
        advanced |= runReady(i);
        if (launch_->hasFailed())
            return Progress::kDone;
    }
    advanced |= release();
    for (const Warp& state : states_)
        anyReady |= state.ready != 0;
    if (advanced || live_ == 0)
        return Progress::kGoesOn;
    if (anyReady)
        return Progress::kWaits; // all ready lanes wait for other blocks or the host
    launch_->deadlock = true;
    return Progress::kDone;
}

// A barrier is complete: returns to rounds if every warp's lanes are ready at one point.
bool BlockRunner::Lockstep::join() {
    mayJoin_ = false;
    for (const BlockBarrier& barrier : barriers_)
        if (barrier.isUsed())
            return false;
    for (size_t i = 0; i < warps_.size(); ++i) {
        const LockstepWarp& warp = warps_[i];
        if (states_[i].ready != warp.live)
            return false;
        const uint32_t point = warp.live ? warp.point[std::countr_zero(warp.live)] : 0;
        if (warp.live & ~lanesWith(warp.point, point, kPointMask))
            return false;
    }
    for (size_t i = 0; i < warps_.size(); ++i) {
        LockstepWarp& warp = warps_[i];
        warp.stopPoint = warp.live ? warp.point[std::countr_zero(warp.live)] & kPointMask : 0;
        states_[i].isAtBarrier = false;
    }
    barrier_ = kNoBarrier;
    isApart_ = false;
    return true;
}

// Completes barriers and exchanges that waited only for lanes that have ended.
bool BlockRunner::Lockstep::release() {
    bool any = false;
    for (uint32_t id = 0; id < barriers_.size(); ++id)
        if (barriers_[id].isUsed())
            any |= tryBarrier(id);
    for (size_t i = 0; i < warps_.size(); ++i)
        while (states_[i].exchange != 0 && tryExchanges(i))
            any = true;
    return any;
}

// Runs the ready lanes. Returns whether any lane did more than reread memory that others may write.
bool BlockRunner::Lockstep::runReady(size_t index) {
    LockstepWarp& warp = warps_[index];
    Warp& state = states_[index];
    bool advanced = false;
    for (uint32_t left = state.ready; left != 0 && !launch_->hasFailed();) {
        const uint32_t point = warp.point[std::countr_zero(left)] & kPointMask;
        const uint32_t lanes = left & lanesWith(warp.point, point, kPointMask);
        const uint32_t ran = runLanes(index, point, lanes);
        left &= ~ran;
        state.ready &= ~ran;
        advanced |= !onlySpin(index, ran);
        takeStops(index, ran & warp.live);
    }
    return advanced;
}

bool BlockRunner::Lockstep::onlySpin(size_t index, uint32_t lanes) const {
    const LockstepWarp& warp = warps_[index];
    if (lanes & ~warp.live)
        return false;
    for (uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
        const uint32_t what = warp.point[std::countr_zero(bits)];
        if (kindOf(what) != devlib::kMeetPause || modeOf(what) != 1)
            return false;
    }
    return true;
}

// Records the points that these lanes have reached.
void BlockRunner::Lockstep::takeStops(size_t index, uint32_t lanes) {
    for (uint32_t left = lanes; left != 0;) {
        const LockstepWarp& warp = warps_[index];
        const uint32_t what = warp.point[std::countr_zero(left)];
        const uint32_t alike = left & lanesWith(warp.point, what, ~uint32_t(0));
        left &= ~alike;
        if (kindOf(what) == devlib::kMeetPause)
            states_[index].ready |= alike;
        else if (kindOf(what) == devlib::kMeetPlain || kindOf(what) == devlib::kMeetBarrier)
            comeToBarrier(index, alike, what);
        else
            states_[index].exchange |= alike;
    }
    while (states_[index].exchange != 0 && tryExchanges(index)) {
    }
}

void BlockRunner::Lockstep::comeToBarrier(size_t index, uint32_t lanes, uint32_t what) {
    const LockstepWarp& warp = warps_[index];
    Warp& state = states_[index];
    state.barrier |= lanes;
    if (kindOf(what) == devlib::kMeetPlain) {
        const uint32_t id = modeOf(what) % BlockBarrier::kCount;
        barriers_[id].waitPlainly(uint32_t(std::popcount(lanes)));
        state.ids[id] |= lanes;
        tryBarrier(id);
        return;
    }
    for (uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
        const auto lane = uint32_t(std::countr_zero(bits));
        const uint32_t id = warp.operand[0][lane] % BlockBarrier::kCount;
        barriers_[id].wait(warp.operand[1][lane], modeOf(what), warp.value[lane] != 0);
        state.ids[id] |= 1u << lane;
        tryBarrier(id);
    }
}

void BlockRunner::Lockstep::arrive(uint32_t id, uint32_t threads) {
    isApart_ = true; // the states of single threads matter now
    barriers_[id % BlockBarrier::kCount].arrive(threads);
    // If this completes the barrier, it is resolved when the running lanes have stopped.
}

void BlockRunner::Lockstep::fault(uint32_t kind) {
    uint32_t none = 0;
    launch_->fault.compare_exchange_strong(none, 1 + kind);
}

bool BlockRunner::Lockstep::tryBarrier(uint32_t id) {
    if (!barriers_[id].isComplete(live_))
        return false;
    const uint32_t result = barriers_[id].result();
    barriers_[id] = {};
    for (size_t i = 0; i < warps_.size(); ++i) {
        const uint32_t lanes = states_[i].ids[id];
        for (uint32_t bits = lanes; bits != 0; bits &= bits - 1)
            warps_[i].result[std::countr_zero(bits)] = result;
        states_[i].ids[id] = 0;
        states_[i].barrier &= ~lanes;
        states_[i].ready |= lanes;
    }
    mayJoin_ = true;
    return true;
}

// Completes one exchange of the warp whose lanes have all arrived; false if there is none.
bool BlockRunner::Lockstep::tryExchanges(size_t index) {
    LockstepWarp& warp = warps_[index];
    Warp& state = states_[index];
    const auto maskOf = [&](uint32_t lane) { return warp.operand[0][lane] | 1u << lane; };
    for (uint32_t leaders = state.exchange; leaders != 0; leaders &= leaders - 1) {
        const auto leader = uint32_t(std::countr_zero(leaders));
        const uint32_t mask = maskOf(leader), partners = mask & warp.live;
        if (partners & ~state.exchange)
            continue;
        bool isComplete = true;
        for (uint32_t bits = partners; bits != 0 && isComplete; bits &= bits - 1)
            isComplete = maskOf(uint32_t(std::countr_zero(bits))) == mask;
        if (!isComplete)
            continue;
        warp.namedEnded |= mask & warp.all & ~warp.live;
        // Lanes may call with different modes: equal ones are computed together.
        for (uint32_t left = partners; left != 0;) {
            const uint32_t what = warp.point[std::countr_zero(left)] & ~kPointMask;
            uint32_t alike = 0;
            for (uint32_t bits = left; bits != 0; bits &= bits - 1)
                if ((warp.point[std::countr_zero(bits)] & ~kPointMask) == what)
                    alike |= bits & -bits;
            compiler::answerLanes(&warp, what, partners, alike);
            left &= ~alike;
        }
        state.exchange &= ~partners;
        state.ready |= partners;
        return true;
    }
    return false;
}

// ---- blocks side by side ----------------------------------------------------------------------

// Blocks run one after the other, except blocks that pause at jumps through memory, or wait. The
// next blocks read the bytes between two jumps of one block, so they run side by side.
void BlockRunner::runLockstep(uint64_t begin, uint64_t end) {
    using Progress = Lockstep::Progress;
    size_t running = 0;
    while (running != 0 || begin != end) {
        if (launch_.stops())
            return;
        if (running == 0)
            startLockstep(running++, begin++);
        bool onlyWait = true;
        for (size_t i = 0; i < running;) {
            const Progress progress = side_[i]->step();
            onlyWait &= progress == Progress::kWaits;
            if (progress == Progress::kDone) {
                std::swap(side_[i], side_[--running]);
                std::swap(sideShared_[i], sideShared_[running]);
                continue;
            }
            if (running < kSideBySide && begin != end)
                startLockstep(running++, begin++);
            ++i;
        }
        if (onlyWait)
            std::this_thread::yield();
    }
}

void BlockRunner::startLockstep(size_t place, uint64_t block) {
    std::unique_ptr<Lockstep>& one = side_[place];
    if (!one || !one->fits(launch_))
        one = std::make_unique<Lockstep>(launch_);
    one->start(launch_, prototypeOf(block, sideShared_[place]));
}

} // namespace sunstone::api::cuda
