// SPDX-License-Identifier: Apache-2.0
// The kernel of pipelines whose closest-hit or miss programs trace. Each function call of a warp
// leaves some lanes behind; rays traced by nested calls would soon be walked one lane at a time. So
// all programs that trace are cut at their traces (compiler/gpu/resumable.h), and a lane keeps its
// waiting programs in arrays: the state of its ray at each depth (0: the launch index), and the
// frames of programs that wait for the next ray. As in loop.h each warp loops, and walks all its
// rays at one place, at any depth.
//
// Where instances have motion, the code of the walk is larger than the instruction cache. All warps
// of a block then walk in step, so that they share the cached code (docs/notes/programs-gpu.md has
// figures).
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
};

// The rays and waiting programs of all depths, and one more ray: a ray that is too deep is
// requested, and ends. Most traces are shallow, and the lanes of a warp are then at the same depth:
// `near` is local memory. Deeper lanes seldom share a depth: `far` is memory of lane_memory.h.
// Pipelines with a small limit of depth have no `far`.
struct Waiting {
    WaitingPart near, far;
    uint32_t nearDepths, frameBytes;

    SUNSTONE_INLINE_MEMBER bool isFar(uint32_t depth) const {
        return far.states && depth >= nearDepths;
    }
    SUNSTONE_INLINE_MEMBER RayState* stateAt(uint32_t depth) const {
        return isFar(depth) ? far.states + (depth - nearDepths) : near.states + depth;
    }
    SUNSTONE_INLINE_MEMBER void* frameAt(uint32_t depth) const {
        return isFar(depth) ? far.frames + uint64_t(depth - nearDepths) * frameBytes
                            : near.frames + uint64_t(depth) * frameBytes;
    }
    // Group of the program at a depth that waits for the ray below.
    SUNSTONE_INLINE_MEMBER uint32_t& groupAt(uint32_t depth) const { return stateAt(depth)->pad; }
};

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
    constexpr bool kInStep = kWithMotion && kMaxLevels > 0; // see LaunchKernel::walksInStep
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
        walkTogether<kInStep>(more, lane, tracer, ray, walker, stack, levels,
                              kNestedPatience * patienceOf(block));
        pace.add(lane);
        if (lane == Lane::kEnded)
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

// `states`, `frames`: near, at least two states; `farStates`, `farFrames`: null if there are none.
extern "C" __attribute__((always_inline)) void
sunstone_gpu_runNested(LaunchBlock* block, void* states, void* frames, void* farStates,
                       void* farFrames, uint32_t nearDepths, uint32_t frameBytes) {
    const Waiting waiting = {{static_cast<RayState*>(states), static_cast<uint8_t*>(frames)},
                             {static_cast<RayState*>(farStates), static_cast<uint8_t*>(farFrames)},
                             nearDepths,
                             frameBytes};
    if (sunstone_gpu_motion)
        runNestedInGraph<true, true>(*block, waiting);
    else if (sunstone_gpu_hasIntersection)
        runNestedInGraph<true, false>(*block, waiting);
    else
        runNestedInGraph<false, false>(*block, waiting);
}

} // namespace sunstone::devlib::gpu
