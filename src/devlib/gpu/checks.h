// SPDX-License-Identifier: Apache-2.0
// Checks of trace calls, traversables, callables, getters and payload types for pipelines with
// debug exceptions, and of the stack: those of the CPU (devlib/checks.cpp, trace_body.h), with the
// same codes and details. Pipelines without the flag contain none of this.
#pragma once

#include "devlib/builtin.h"
#include "devlib/gpu/exceptions.h"
#include "devlib/gpu/getters.h"
#include "devlib/hit_rules.h"

namespace sunstone::devlib::gpu {

SUNSTONE_INLINE bool debugging() {
    return sunstone_gpu_exceptionFlags & kFlagDebug;
}

[[noreturn]] SUNSTONE_INLINE void raiseWithoutPath(RayState* state, int32_t code,
                                                   const ExceptionInfo& info) {
    state->hit.transformCount = 0;
    raise(state, code, &info);
}

// ---- trace calls --------------------------------------------------------------------------------

// Floats must be finite, flags must not exclude each other.
[[gnu::noinline]] static void checkRay(RayState* state) {
    ExceptionInfo info{};
    for (int i = 0; i < 3; ++i) {
        info.ray[i] = state->worldOrigin[i];
        info.ray[3 + i] = state->worldDirection[i];
    }
    info.ray[6] = state->tmin;
    info.ray[7] = state->tmax;
    info.ray[8] = state->time;
    info.line = state->line;
    for (float value : info.ray)
        if ((__builtin_bit_cast(uint32_t, value) & 0x7F800000u) == 0x7F800000u)
            raiseWithoutPath(state, kExceptionInvalidRay, info);
    constexpr uint32_t kAnyHit =
        kRayDisableAnyHit | kRayEnforceAnyHit | kRayCullDisabledAnyHit | kRayCullEnforcedAnyHit;
    constexpr uint32_t kFaces = kRayCullBack | kRayCullFront;
    for (float& value : info.ray)
        value = 0;
    if (__builtin_popcount(state->rayFlags & kAnyHit) > 1 || (state->rayFlags & kFaces) == kFaces)
        raiseWithoutPath(state, kExceptionInvalidArgument0, info);
    // Eight bits are used here, as the manual requires; some processors use only four.
    if (state->sbtOffset > 15 || state->sbtStride > 15)
        reportOf(state).wideSbt = 1;
}

// ---- traversables -------------------------------------------------------------------------------

// The exception code of a traversable that does not fit the pipeline, below `above` others; else 0.
SUNSTONE_INLINE int32_t faultOf(const RayState* state, uint64_t handle, uint32_t above) {
    const HandleTag tag = tagOf(handle);
    const bool isTransform = tag == kTagStatic || tag == kTagMatrixMotion || tag == kTagSrtMotion;
    if (isTransform && !isKnown(state->launch, handle))
        return kExceptionInvalidTraversable;
    return faultOfTraversable(*state->launch, tag,
                              isTransform ? nullptr : blockOf(state->launch, handle, tag), above);
}

// Raises the exception of a traversable that does not fit. `path`: the instances and transforms
// entered before it. The null handle is never hit.
[[gnu::noinline]] static void checkTraversable(RayState* state, uint64_t handle,
                                               const uint64_t* path, uint32_t above) {
    if (handle == 0)
        return;
    const int32_t depth = above + 1 > state->launch->maxGraphDepth ? kExceptionTraversalDepth : 0;
    const int32_t code = depth || !debugging() ? depth : faultOf(state, handle, above);
    if (code == 0)
        return;
    state->hit.transformCount = above;
    for (uint32_t i = 0; i < above; ++i)
        state->hit.transforms[i] = path[i];
    ExceptionInfo info{};
    if (code == kExceptionUnsupportedPrimitive)
        info.line = state->line;
    else if (code != kExceptionTraversalDepth)
        info.traversable = handle;
    raise(state, code, &info);
}

// Before the child of an instance or transform is entered.
SUNSTONE_INLINE void checkChild(RayState* state, uint64_t child, const uint64_t* path,
                                uint32_t above) {
    if (debugging() || raisesDepth(*state->launch))
        checkTraversable(state, child, path, above);
}

// Whether the ray's handle is valid; otherwise the ray misses, and the log reports it. Programs
// tend to use one handle for all rays, which is the usual one from the second launch on.
SUNSTONE_INLINE bool leadsSomewhere(RayState* state) {
    const uint64_t handle = state->handle;
    if constexpr (Records::kOwnHandles)
        return handle != 0;
    const LaunchBlock& block = blockOf(state->launch);
    if (__builtin_expect(handle == sunstone_gpu_usual(&block), 1))
        return true;
    LaunchReport& report = reportOf(state);
    if (isInTable(block, handle)) {
        if (report.usual == 0)
            report.usual = handle;
        return true;
    }
    if (handle != 0)
        report.unknown = handle;
    return false;
}

// The same for a child that may have changed since its parent was built.
SUNSTONE_INLINE bool childLeadsSomewhere(RayState* state, uint64_t child) {
    if constexpr (Records::kOwnHandles)
        return child != 0;
    if (isKnown(state->launch, child))
        return true;
    if (child != 0)
        reportOf(state).unknown = child;
    return false;
}

// Before a ray is traced.
SUNSTONE_INLINE void checkTrace(RayState* state) {
    if (!debugging())
        return;
    checkRay(state);
    checkTraversable(state, state->handle, nullptr, 0);
}

// ---- records ------------------------------------------------------------------------------------

// Raises this code unless the record exists and holds a group of the pipeline, of that kind.
[[gnu::noinline]] static void checkGroup(RayState* state, int32_t code, uint64_t record,
                                         GroupKind kind, uint64_t index) {
    const uint32_t group = record ? groupOf(*state->launch, record, kind) : kNoGroup;
    if (group != kNoGroup && sunstone_gpu_isGroup(group))
        return;
    ExceptionInfo info{};
    info.sbtOffset = uint32_t(index);
    raise(state, code, &info);
}
// The state already has the path.
SUNSTONE_INLINE void checkRecord(RayState* state, int32_t code, uint64_t record, GroupKind kind,
                                 uint64_t index) {
    if (debugging())
        checkGroup(state, code, record, kind, index);
}

// Whether the pipeline has a group with this number.
SUNSTONE_INLINE bool hasGroup(const RayState* state, uint32_t group) {
    return group < state->launch->groupCount;
}
SUNSTONE_INLINE void noteRecord(RayState* state, NeededProgram program, uint64_t index) {
    reportOf(state).record = recordNote(program, index);
}
// Logs that no program runs at a hit or a miss, because the application's record is missing or
// wrong.
SUNSTONE_INLINE void noteRecord(RayState* state, uint32_t group, NeededProgram program,
                                uint64_t index) {
    if constexpr (!Records::kOwnRecords)
        if (__builtin_expect(!hasGroup(state, group), 0))
            noteRecord(state, program, index);
}

// Raises unless the hit group is one for the primitives of the structure.
[[gnu::noinline]] static void checkBuiltinOf(RayState* state, uint32_t group, uint64_t gas,
                                             uint32_t sbtGasIndex) {
    if (!fitsBuiltin(sunstone_gpu_builtin(group), blockOf(gas, kTagGas), sbtGasIndex))
        raise(state, kExceptionBuiltinIsMismatch);
}
SUNSTONE_INLINE void checkBuiltin(RayState* state, uint32_t group, uint64_t gas,
                                  uint32_t sbtGasIndex) {
    if (debugging() && group != kNoGroup)
        checkBuiltinOf(state, group, gas, sbtGasIndex);
}

SUNSTONE_INLINE void checkHitKind(RayState* state, uint32_t kind) {
    if (debugging() && kind > 127)
        raise(state, kExceptionInvalidArgument0 - 1);
}

// ---- callables ----------------------------------------------------------------------------------

// `call` as in LaunchState::callable; `code`: the code to call.
[[gnu::noinline]] static void checkCallable(RayState* state, uint32_t sbtIndex, uint32_t call,
                                            uint32_t group, const void* code) {
    const SbtView& sbt = state->launch->sbt;
    const uint32_t continuation = call & 1, passed = call >> 8;
    ExceptionInfo info{};
    info.sbtOffset = sbtIndex;
    if (sbt.callableBase == 0 || sbtIndex >= sbt.callableCount)
        raise(state, kExceptionCallableInvalidSbt, &info);
    if (!code)
        raise(state, continuation ? kExceptionNoContinuationCallable : kExceptionNoDirectCallable,
              &info);
    const uint32_t expected = sunstone_gpu_callableWords(2 * group + continuation);
    if (expected == passed)
        return;
    info.sbtOffset = 0;
    info.expectedWords = expected;
    info.passedWords = passed;
    info.callableIndex = sbtIndex;
    info.callableName = sunstone_gpu_callableName(2 * group + continuation);
    info.line = state->thread->line;
    raise(state, kExceptionParameterMismatch, &info);
}

// Raises if the stack is exhausted.
SUNSTONE_INLINE void checkStack(RayState* state) {
    if (!(sunstone_gpu_exceptionFlags & kFlagStackOverflow))
        return;
    volatile uint32_t here = 0;
    if (reinterpret_cast<uint64_t>(&here) < state->thread->stackLimit)
        raise(state, kExceptionStackOverflow);
}

// ---- getters ------------------------------------------------------------------------------------

SUNSTONE_INLINE void checkVertices(RayState* state, uint64_t gas, uint32_t primitive,
                                   uint32_t sbtGasIndex) {
    const bvh::BlockHeader* const block = blockOf(state->launch, gas, kTagGas);
    if (!block || bvh::kindOf(block->type) == bvh::BlockType::kInstances)
        raise(state, kExceptionInvalidArgument0);
    if (!(block->options & bvh::kOptionVertexAccess))
        raise(state, kExceptionUnsupportedDataAccess);
    const auto* const inputs = reinterpret_cast<const bvh::InputRecord*>(
        reinterpret_cast<const uint8_t*>(block) + block->inputsOffset);
    for (uint32_t i = 0; i < block->numInputs; ++i) {
        const bvh::InputRecord& input = inputs[i];
        if (sbtGasIndex - input.firstSbtIndex >= input.numSbtRecords)
            continue;
        if (primitive - input.primitiveIndexOffset >= input.numPrimitives)
            raise(state, kExceptionInvalidArgument0 - 1);
        return;
    }
    raise(state, kExceptionInvalidArgument0 - 2);
}

SUNSTONE_INLINE void checkInstance(RayState* state, uint64_t ias, uint32_t index) {
    const bvh::BlockHeader* const block = blockOf(state->launch, ias, kTagIas);
    if (!block)
        raise(state, kExceptionInvalidArgument0);
    if (!(block->options & bvh::kOptionInstanceAccess))
        raise(state, kExceptionUnsupportedDataAccess);
    if (index >= block->numPrimitives)
        raise(state, kExceptionInvalidArgument0 - 1);
}

extern "C" [[gnu::noinline]] void sunstone_gpu_checkAccess(RayState* state, uint32_t kind,
                                                           uint64_t handle, uint32_t first,
                                                           uint32_t second) {
    switch (kind) {
    case kAccessVertices:
        return checkVertices(state, handle, first, second);
    case kAccessInstance:
        return checkInstance(state, handle, first);
    case kAccessTransformList:
        if (first >= state->hit.transformCount)
            raise(state, kExceptionInvalidArgument0);
        return;
    case kAccessMotion: {
        const bvh::BlockHeader* const block = blockOf(state->launch, handle, kTagGas);
        if (!block || bvh::kindOf(block->type) == bvh::BlockType::kInstances)
            raise(state, kExceptionInvalidArgument0);
        return;
    }
    default:
        return;
    }
}

} // namespace sunstone::devlib::gpu
