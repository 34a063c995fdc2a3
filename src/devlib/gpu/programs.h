// SPDX-License-Identifier: Apache-2.0
// The functions and constants that the compiler adds to the run-time in each pipeline's module:
// dispatchers to the programs by group number, and constants known when the pipeline is made, which
// let the compiler drop unused code.
#pragma once

#include "base/inline.h"
#include "bvh/gpu/known_handles.h"
#include "devlib/gpu/launch_block.h"
#include "devlib/records.h"

namespace sunstone::devlib::gpu {

// A large function with few callers in a pipeline. It stays out of line until the callers are known
// (compiler/gpu/link.cpp), and is then inlined into each.
#define SUNSTONE_DEVICE_PART __attribute__((noinline, section(".sunstone.part"))) static

// Result of dispatchers for a group without such a program.
constexpr uint32_t kNoProgram = ~0u;

extern "C" {
uint32_t sunstone_gpu_raygen(RayState*, uint32_t group);
// start runs the ray generation program to its first trace, resume from there to the next one. They
// fill `ray` and set `asks` if the program requests a ray.
uint32_t sunstone_gpu_start(RayState* root, RayState* ray, void* frame, uint32_t* asks,
                            uint32_t group);
uint32_t sunstone_gpu_resume(RayState* root, RayState* ray, void* frame, uint32_t* asks,
                             uint32_t group);
uint32_t sunstone_gpu_findRaygen(uint32_t group); // whether there is such a program
// The same for closest-hit and miss programs, whose state is `state`, and for programs of any kind.
uint32_t sunstone_gpu_startHit(RayState* state, RayState* ray, void* frame, uint32_t* asks,
                               uint32_t group);
uint32_t sunstone_gpu_startMiss(RayState* state, RayState* ray, void* frame, uint32_t* asks,
                                uint32_t group);
uint32_t sunstone_gpu_resumeAny(RayState* state, RayState* ray, void* frame, uint32_t* asks,
                                uint32_t group);
uint32_t sunstone_gpu_exception(RayState*, uint32_t group);
uint32_t sunstone_gpu_miss(RayState*, uint32_t group);
uint32_t sunstone_gpu_closestHit(RayState*, uint32_t group);
uint32_t sunstone_gpu_anyHit(RayState*, uint32_t group);
uint32_t sunstone_gpu_intersection(RayState*, struct Candidates*, uint32_t group);
uint32_t sunstone_gpu_attribute(RayState*, uint32_t group);
uint32_t sunstone_gpu_visit(RayState*, uint32_t group);
const void* sunstone_gpu_direct(uint32_t group);
const void* sunstone_gpu_continuation(uint32_t group);
// `callable`: 2 * group, or 2 * group + 1 for the continuation callable.
uint32_t sunstone_gpu_callableWords(uint32_t callable); // words of its parameters
const char* sunstone_gpu_callableName(uint32_t callable);
uint32_t sunstone_gpu_isGroup(uint32_t group); // the pipeline has it
uint32_t sunstone_gpu_builtin(uint32_t group); // GroupEntry::builtinPrimitive of a hit group

// LaunchConstants. In the kernel itself they are its arguments (compiler/gpu/launch_kernel.cpp).
__attribute__((const)) uint64_t sunstone_gpu_usual(const LaunchBlock*);
__attribute__((const)) uint64_t sunstone_gpu_known(const LaunchBlock*);
__attribute__((const)) uint64_t sunstone_gpu_maxGraphDepth(const LaunchBlock*);

extern const uint32_t sunstone_gpu_hasAnyHit;
extern const uint32_t sunstone_gpu_hasIntersection;
extern const uint32_t sunstone_gpu_micromaps;      // rays test opacity micromaps
extern const uint32_t sunstone_gpu_shapes;         // bvh::gpu::ShapeBits that rays may meet
extern const uint32_t sunstone_gpu_hasBounds;      // some group is a bounds program
extern const uint32_t sunstone_gpu_hasVisits;      // some group is a visit program
extern const uint32_t sunstone_gpu_hasException;   // some group is an exception program
extern const uint32_t sunstone_gpu_exceptionFlags; // with kGpuFactOfLaunch: kFlagTraceDepth as
                                                   // the launch has it, and no other checks
extern const uint32_t sunstone_gpu_graph;          // GraphKind
extern const uint32_t sunstone_gpu_inStep;         // the warps of a block walk in step (nested.h)
extern const uint32_t sunstone_gpu_longIntersections; // lanes wait with intersection programs
extern const uint32_t sunstone_gpu_motion;            // MotionKind
}

// A fact of which the constant in code for many pipelines is kGpuFactOfLaunch.
SUNSTONE_INLINE bool holds(uint32_t constant, uint32_t ofLaunch) {
    return constant & kGpuFactOfLaunch ? ofLaunch : constant;
}

// Whether rays and graphs that are too deep raise exceptions.
SUNSTONE_INLINE bool raisesDepth(const LaunchState& launch) {
    const uint32_t flags = sunstone_gpu_exceptionFlags;
    return (flags & kGpuFactOfLaunch ? launch.exceptionFlags : flags) & kFlagTraceDepth;
}

// The rule by which the API generation of this run-time finds records.
#ifndef SUNSTONE_RECORDS
#define SUNSTONE_RECORDS SbtRecords
#endif
using Records = SUNSTONE_RECORDS;

SUNSTONE_INLINE LaunchBlock& blockOf(const LaunchState* launch) {
    // LaunchState is the block's first member.
    return *reinterpret_cast<LaunchBlock*>(const_cast<LaunchState*>(launch));
}

// Whether a handle is in the table. In graphs only pipelines with debug exceptions receive a table.
SUNSTONE_INLINE bool isInTable(const LaunchBlock& block, uint64_t handle) {
    const uint64_t known = sunstone_gpu_known(&block);
    return bvh::gpu::isKnownHandle(
        sunstone_gpu_exceptionFlags & kFlagDebug ? bvh::gpu::knownNow(known) : known, handle);
}

// Whether a handle is that of a structure with allocated memory, or of a transform.
SUNSTONE_INLINE bool isKnown(const LaunchState* launch, uint64_t handle) {
    const LaunchBlock& block = blockOf(launch);
    return handle == sunstone_gpu_usual(&block) || isInTable(block, handle);
}

} // namespace sunstone::devlib::gpu
