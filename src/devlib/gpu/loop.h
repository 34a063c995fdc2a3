// SPDX-License-Identifier: Apache-2.0
// The kernel of pipelines whose ray generation programs the compiler has cut at their trace
// (compiler/gpu/resumable.h). Rays of a warp end at different times, and lanes that waited for the
// longest ray would be idle most of the time. So each warp loops: it gives new launch indices to
// idle lanes, walks all rays until idle lanes have cost enough, then runs the programs of the rays
// that have ended. Other traces run to their end where they are called (sunstone_gpu_trace). Such
// pipelines have no motion.
//
// There are as many warps as tiles of launch indices. Warps that start when all indices are taken
// do nothing. A warp that has lost lanes to exceptions ends when its other lanes are idle, and
// another warp takes its place.
#pragma once

#include "devlib/gpu/run.h"
#include "devlib/gpu/trace.h"

namespace sunstone::devlib::gpu {

constexpr uint32_t kAllLanes = ~0u;

SUNSTONE_INLINE uint32_t ballot(bool value) {
    return __nvvm_vote_ballot_sync(kAllLanes, value);
}

SUNSTONE_INLINE uint32_t countOf(uint32_t lanes) {
    return uint32_t(__builtin_popcount(lanes));
}

// Gives each of the `wanting` lanes a number of its own. All lanes of the warp call this.
SUNSTONE_INLINE uint64_t takeNumber(LaunchWork& work, uint32_t wanting) {
    const uint32_t lane = uint32_t(__nvvm_read_ptx_sreg_laneid());
    const int leader = __builtin_ctz(wanting);
    uint64_t first = 0;
    if (int(lane) == leader)
        first = uint64_t(
            __nvvm_atom_add_gen_ll(reinterpret_cast<long long*>(&work.next), countOf(wanting)));
    const auto low = uint32_t(__nvvm_shfl_sync_idx_i32(kAllLanes, int(first), leader, 31));
    const auto high = uint32_t(__nvvm_shfl_sync_idx_i32(kAllLanes, int(first >> 32), leader, 31));
    return (uint64_t(high) << 32 | low) + countOf(wanting & ((1u << lane) - 1));
}

SUNSTONE_INLINE uint32_t patienceIndex() {
    return uint32_t(__nvvm_read_ptx_sreg_ctaid_x()) % kPatienceWays;
}
SUNSTONE_INLINE uint32_t patienceOf(const LaunchBlock& block) {
    return block.work.patience[patienceIndex()] & ~kWithBlock;
}

// State of a lane.
enum class Lane : uint32_t {
    kIdle,    // it has no launch index
    kAsks,    // its program requests a ray
    kWalking, // the ray is being walked
    kEnded,   // the ray has ended: its programs run next, then the ray generation program
};

// Whether an idle lane has got a launch index. `more`: there may be further ones. All lanes of the
// warp call this.
SUNSTONE_INLINE bool takeIndex(LaunchBlock& block, Lane lane, bool& more, uint32_t index[3]) {
    const uint32_t idle = ballot(lane == Lane::kIdle);
    if (!more || idle == 0 || (idle != kAllLanes && patienceOf(block) >= kTilePatience))
        return false;
    const uint64_t number = takeNumber(block.work, idle);
    const bool exists = number < block.work.count;
    more = ballot(lane == Lane::kIdle && !exists) == 0;
    return lane == Lane::kIdle && exists &&
           findIndex(block.launch.dimensions, uint32_t(number / kGpuTile),
                     uint32_t(number % kGpuTile), index);
}

// Whether a warp has no work. It continues while there are indices, because a warp that ends before
// the others of its block leaves its place unused. All lanes of the warp call this.
SUNSTONE_INLINE bool isThrough(Lane lane, bool more) {
    return ballot(lane != Lane::kIdle) == 0 && (!more || ballot(true) != kAllLanes);
}

// Starts the ray that a program has requested.
template <class Programs, class Walk>
SUNSTONE_INLINE Lane begin(RayState* asked, Programs& tracer, walk::Ray& ray, Walk& walker,
                           typename Walk::Level* levels) {
    prepare(asked, tracer, ray);
    if (withinDepth(asked))
        return leadsSomewhere(asked) && startWalk(asked, tracer, ray, walker, levels)
                   ? Lane::kWalking
                   : Lane::kEnded;
    tracer.found = true; // as if found by a ray without programs
    tracer.rayFlags = kRayDisableClosestHit;
    return Lane::kEnded;
}

// Counts a warp's rays and its time.
class PaceCounter {
public:
    SUNSTONE_INLINE_MEMBER PaceCounter() : start_(now()), rays_(0) {}
    // All lanes of the warp call this.
    SUNSTONE_INLINE_MEMBER void add(bool ended) { rays_ += countOf(ballot(ended)); }
    SUNSTONE_INLINE_MEMBER void report(LaunchBlock& block) const {
        if (!block.work.isMeasured || __nvvm_read_ptx_sreg_laneid() != 0)
            return;
        const uint32_t time = now() - start_;
        WarpPace& pace = block.report.paces[patienceIndex()];
        __nvvm_atom_add_gen_ll(reinterpret_cast<long long*>(&pace.rays), rays_);
        __nvvm_atom_add_gen_ll(reinterpret_cast<long long*>(&pace.time), time);
    }

private:
    // The clock in one register.
    static SUNSTONE_INLINE_MEMBER uint32_t now() {
        return uint32_t(uint64_t(__nvvm_read_ptx_sreg_clock64()) >> 8);
    }

    uint32_t start_, rays_;
};

// The number of threads of the block with a true `value`. Waits for all that have not ended.
SUNSTONE_INLINE uint32_t countInBlock(bool value) {
    uint32_t count;
    asm volatile("{ .reg .pred p; setp.ne.u32 p, %1, 0; barrier.red.popc.u32 %0, 0, p; }"
                 : "=r"(count)
                 : "r"(uint32_t(value))
                 : "memory");
    return count;
}
// The same number for the warp, or a warp's mean if all warps of the block walk in step.
template <bool kInStep>
SUNSTONE_INLINE uint32_t countLanes(bool value) {
    constexpr uint32_t kWarps = kGpuStepBlockThreads / kGpuTile;
    return kInStep ? (countInBlock(value) + kWarps - 1) / kWarps : countOf(ballot(value));
}

// Walks all rays until idle lanes have cost enough. All lanes of the warp call this, with kInStep
// all threads of the block.
template <bool kInStep, class Programs, class Walk>
SUNSTONE_INLINE void walkTogether(bool more, Lane& lane, Programs& tracer, walk::Ray& ray,
                                  Walk& walker, walk::U2* stack, typename Walk::Level* levels,
                                  uint32_t patience) {
    const uint32_t lanes = !kInStep && more ? 32 : countLanes<kInStep>(more || lane != Lane::kIdle);
    for (;;) {
        if (lane == Lane::kWalking && walker.step(tracer, ray, stack, levels))
            lane = Lane::kEnded;
        const uint32_t walking = countLanes<kInStep>(lane == Lane::kWalking);
        if (walking == 0 || lanes - walking >= patience)
            break;
        patience -= lanes - walking;
    }
}

// Before programs run. Warps that have ended do not count.
SUNSTONE_INLINE void waitForBlock(const LaunchBlock& block) {
    if (block.work.patience[patienceIndex()] & kWithBlock)
        countInBlock(false);
}

template <bool kWithCustoms, unsigned kMaxLevels>
SUNSTONE_DEVICE_PART void runLanes(LaunchBlock& block, void* frame) {
    using Programs = Tracer<kWithCustoms, kMaxLevels, false>;
    using Walk = walk::Traversal<Programs>;
    const LaunchState& launch = block.launch;
    RayState root, asked; // of the launch index, and of the ray that its program requests
    ThreadState thread;
    prepareRoot(launch, root, thread);
    asked.launch = &launch;
    asked.thread = &thread;
    const uint32_t group = groupOf(launch, launch.sbt.entryRecord, GroupKind(launch.entryKind));
    if (sunstone_gpu_findRaygen(group) == kNoProgram) {
        note(block.report.fatal, 0, kFatalRaygenRecord);
        return;
    }
    Programs tracer;
    typename Programs::Path path;
    bind(&asked, tracer, path);
    walk::Ray ray;
    Walk walker;
    walk::U2 stack[Walk::kStackSize];
    typename Walk::Level levels[kMaxLevels + 1];
    Lane lane = Lane::kIdle;
    bool more = true;
    PaceCounter pace;
    for (;;) {
        if (takeIndex(block, lane, more, thread.index)) {
            uint32_t asks = 0;
            prepareEntry(root);
            sunstone_gpu_start(&root, &asked, frame, &asks, group);
            lane = asks ? Lane::kAsks : Lane::kIdle;
        }
        if (lane == Lane::kAsks)
            lane = begin(&asked, tracer, ray, walker, levels);
        walkTogether<false>(more, lane, tracer, ray, walker, stack, levels, patienceOf(block));
        waitForBlock(block);
        pace.add(lane == Lane::kEnded);
        if (lane == Lane::kEnded) {
            uint32_t hitGroup = 0;
            const Found found = conclude(tracer, ray, hitGroup);
            runPrograms(&asked, found, hitGroup, ray.tmax);
            uint32_t asks = 0;
            sunstone_gpu_resume(&root, &asked, frame, &asks, group);
            lane = asks ? Lane::kAsks : Lane::kIdle;
        }
        if (isThrough(lane, more))
            return pace.report(block);
    }
}

template <bool kWithCustoms>
SUNSTONE_INLINE void runLanesInGraph(LaunchBlock& block, void* frame) {
    switch (sunstone_gpu_graph) {
    case kGraphGas:
        return runLanes<kWithCustoms, 0>(block, frame);
    case kGraphSingleLevel:
    case kGraphShallow:
        return runLanes<kWithCustoms, 1>(block, frame);
    default:
        return runLanes<kWithCustoms, kMaxGpuGraphDepth>(block, frame);
    }
}

extern "C" __attribute__((always_inline)) void sunstone_gpu_runLoop(LaunchBlock* block,
                                                                    void* frame) {
    if (sunstone_gpu_hasIntersection)
        runLanesInGraph<true>(*block, frame);
    else
        runLanesInGraph<false>(*block, frame);
}

} // namespace sunstone::devlib::gpu
