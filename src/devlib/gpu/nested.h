// SPDX-License-Identifier: Apache-2.0
// The kernel of pipelines whose closest-hit or miss programs trace. Each function call of a warp
// leaves some lanes behind; rays traced by nested calls would soon be walked one lane at a time. So
// all programs that trace are cut at their traces (compiler/gpu/resumable.h), and a lane keeps its
// waiting programs in arrays: the state of its ray at each depth (0: the launch index), and the
// frames of programs that wait for the next ray. As in loop.h each warp loops, and walks all its
// rays at one place, at any depth.
//
// Where instances have motion, the code of the walk is larger than the instruction cache. If
// closest-hit or miss programs trace, all warps of a block then walk in step, so that they share
// the cached code (docs/notes/programs-gpu.md has figures).
#pragma once

#include "devlib/gpu/loop.h"

namespace sunstone::devlib::gpu {

// The work between walks is larger for each ray than in loop.h, with states in memory. Longer waits
// let more lanes do it together.
constexpr uint32_t kNestedPatience = 8;

// The rays of a launch index in one range of depths, and the programs that wait there.
struct WaitingPart {
    RayState* states;
    uint8_t* frames;
    uint32_t frameBytes;
};

// The rays and waiting programs of all depths, and one more ray: a ray that is too deep is
// requested, and ends. Most traces are shallow, and the lanes of a warp are then at the same depth:
// `near` is local memory. Deeper lanes seldom share a depth: `far` is memory of lane_memory.h.
// Pipelines with a small limit of depth have no `far`.
struct Waiting {
    WaitingPart near, far;
    uint32_t nearDepths;

    SUNSTONE_INLINE_MEMBER bool isFar(uint32_t depth) const {
        return far.states && depth >= nearDepths;
    }
    SUNSTONE_INLINE_MEMBER RayState* stateAt(uint32_t depth) const {
        return isFar(depth) ? far.states + (depth - nearDepths) : near.states + depth;
    }
    SUNSTONE_INLINE_MEMBER void* frameAt(uint32_t depth) const {
        return isFar(depth) ? far.frames + uint64_t(depth - nearDepths) * far.frameBytes
                            : near.frames + uint64_t(depth) * near.frameBytes;
    }
    // Group of the program at a depth that waits for the ray below.
    SUNSTONE_INLINE_MEMBER uint32_t& groupAt(uint32_t depth) const { return stateAt(depth)->pad; }
};

constexpr uint32_t kMostDepth = 32; // of rays, a power of two

// The lanes with the largest depth among those that are `busy`. All lanes of the warp call this.
SUNSTONE_INLINE uint32_t deepestLanes(bool busy, uint32_t depth) {
    uint32_t lanes = ballot(busy);
#pragma clang loop unroll(full)
    for (uint32_t bit = kMostDepth; bit != 0; bit >>= 1) {
        const uint32_t set = ballot(depth & bit) & lanes;
        lanes = set != 0 ? set : lanes;
    }
    return lanes;
}

// Runs the programs at the end of the ray at `depth`, and those that waited for it. True: the state
// at the new `depth` requests a ray. False: the launch index has ended.
template <class Programs>
SUNSTONE_INLINE bool goOn(const Waiting& waiting, Programs& tracer, const walk::Ray& ray,
                          uint32_t& depth) {
    RayState* state = waiting.stateAt(depth);
    uint32_t group = kNoGroup;
    const Found found = conclude(tracer, ray, group);
    uint32_t asks = 0;
    if (found == Found::kHit) {
        sunstone_gpu_startHit(state, waiting.stateAt(depth + 1), waiting.frameAt(depth), &asks,
                              group);
    } else if (found == Found::kNothing) {
        state->tmax = ray.tmax;
        group = prepareMiss(state);
        sunstone_gpu_startMiss(state, waiting.stateAt(depth + 1), waiting.frameAt(depth), &asks,
                               group);
    }
    for (;;) {
        if (asks) {
            waiting.groupAt(depth++) = group;
            return true;
        }
        if (depth == 0)
            return false;
        state = waiting.stateAt(--depth);
        group = waiting.groupAt(depth);
        sunstone_gpu_resumeAny(state, waiting.stateAt(depth + 1), waiting.frameAt(depth), &asks,
                               group);
    }
}

template <bool kWithCustoms, unsigned kMaxLevels, bool kWithMotion>
SUNSTONE_DEVICE_PART void runNested(LaunchBlock& block, const Waiting& waiting) {
    using Programs = Tracer<kWithCustoms, kMaxLevels, kWithMotion>;
    using Walk = walk::Traversal<Programs>;
    RayState& root = *waiting.near.states;
    ThreadState thread;
    prepareRoot(block.launch, root, thread);
    const uint32_t group =
        groupOf(block.launch, block.launch.sbt.entryRecord, GroupKind(block.launch.entryKind));
    if (sunstone_gpu_findRaygen(group) == kNoProgram) {
        note(block.report.fatal, 0, kFatalRaygenRecord);
        return;
    }
    Programs tracer;
    typename Programs::Path path;
    bind(&root, tracer, path);
    walk::Ray ray;
    Walk walker;
    walk::U2 stack[Walk::kStackSize];
    typename Walk::Level levels[kMaxLevels + 1];
    Lane lane = Lane::kIdle;
    uint32_t depth = 0;
    bool more = true;
    PaceCounter pace;
    for (;;) {
        if (takeIndex(block, lane, more, thread.index)) {
            uint32_t asks = 0;
            prepareEntry(root);
            sunstone_gpu_start(&root, waiting.near.states + 1, waiting.near.frames, &asks, group);
            if (asks) {
                waiting.groupAt(0) = group;
                depth = 1;
                lane = Lane::kAsks;
            }
        }
        if (lane == Lane::kAsks) {
            tracer.state = waiting.stateAt(depth);
            lane = begin(tracer.state, tracer, ray, walker, levels);
        }
        const uint32_t patience = kNestedPatience * patienceOf(block);
        if (sunstone_gpu_inStep)
            walkTogether<true>(more, lane, tracer, ray, walker, stack, levels, patience);
        else
            walkTogether<false>(more, lane, tracer, ray, walker, stack, levels, patience);
        waitForBlock(block);
        bool goes = lane == Lane::kEnded;
        if (patienceOf(block) == kDepthPatience) { // all lanes with a ray have ended it
            const uint32_t deepest = deepestLanes(goes, depth);
            goes = deepest >> uint32_t(__nvvm_read_ptx_sreg_laneid()) & 1;
        }
        pace.add(goes);
        if (goes)
            lane = goOn(waiting, tracer, ray, depth) ? Lane::kAsks : Lane::kIdle;
        if (isThrough(lane, more))
            return pace.report(block);
    }
}

template <bool kWithCustoms, bool kWithMotion>
SUNSTONE_INLINE void runNestedInGraph(LaunchBlock& block, const Waiting& waiting) {
    switch (sunstone_gpu_graph) {
    case kGraphGas:
        return runNested<kWithCustoms, 0, kWithMotion>(block, waiting);
    case kGraphSingleLevel:
    case kGraphShallow:
        return runNested<kWithCustoms, 1, kWithMotion>(block, waiting);
    default:
        return runNested<kWithCustoms, kMaxGpuGraphDepth, kWithMotion>(block, waiting);
    }
}

SUNSTONE_INLINE void startNested(LaunchBlock& block, const Waiting& waiting) {
    if (sunstone_gpu_motion)
        runNestedInGraph<true, true>(block, waiting);
    else if (sunstone_gpu_hasIntersection)
        runNestedInGraph<true, false>(block, waiting);
    else
        runNestedInGraph<false, false>(block, waiting);
}

// `states`, `frames`: near, at least two states; `farStates`, `farFrames`: null if there are none.
extern "C" __attribute__((always_inline)) void
sunstone_gpu_runNested(LaunchBlock* block, void* states, void* frames, void* farStates,
                       void* farFrames, uint32_t nearDepths, uint32_t frameBytes) {
    startNested(*block,
                {{static_cast<RayState*>(states), static_cast<uint8_t*>(frames), frameBytes},
                 {static_cast<RayState*>(farStates), static_cast<uint8_t*>(farFrames), frameBytes},
                 nearDepths});
}

// In code for many pipelines, which have more depths: the far part is memory that the warp claims,
// of a size that depends on the pipeline.
extern "C" __attribute__((always_inline)) void
sunstone_gpu_runNestedDeep(LaunchBlock* block, void* states, void* frames, uint32_t nearDepths,
                           uint32_t frameBytes) {
    const uint64_t farBytes = block->work.laneMemory.frameBytes;
    const FarLayout layout(block->launch.maxTraceDepth, nearDepths, farBytes);
    uint8_t* const own = sunstone_gpu_claimLaneMemory(block) +
                         uint64_t(uint32_t(__nvvm_read_ptx_sreg_laneid())) * layout.bytes;
    startNested(*block,
                {{static_cast<RayState*>(states), static_cast<uint8_t*>(frames), frameBytes},
                 {reinterpret_cast<RayState*>(own), own + layout.stateBytes, uint32_t(farBytes)},
                 nearDepths});
    sunstone_gpu_freeLaneMemory();
}

} // namespace sunstone::devlib::gpu
