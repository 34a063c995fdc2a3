// SPDX-License-Identifier: Apache-2.0
#include "devlib/checks.h"

#include "base/readable.h"
#include "bvh/build/build.h"
#include "bvh/input/input_lookup.h"
#include "bvh/layout.h"
#include "devlib/builtin.h"
#include "devlib/flags.h"
#include "devlib/launch_notes.h"
#include "devlib/records.h"

#include <cmath>

namespace sunstone::devlib {
namespace {

void raise(RayState* state, int32_t code, const ExceptionInfo* info = nullptr) {
    state->launch->raise(state, code, info);
}

// The block behind a handle of this kind, or null.
const bvh::BlockHeader* blockOf(uint64_t handle, HandleTag tag) {
    const auto* block = reinterpret_cast<const void*>(addressOf(handle));
    if (tagOf(handle) != tag || !isReadable(block, sizeof(bvh::BlockHeader)) ||
        !bvh::isBlock(block))
        return nullptr;
    return bvh::headerOf(block);
}

void checkVertices(RayState* state, uint64_t gas, uint32_t primitive, uint32_t sbtGasIndex) {
    const bvh::BlockHeader* block = blockOf(gas, kTagGas);
    if (!block || bvh::kindOf(block->type) == bvh::BlockType::kInstances)
        return raise(state, kExceptionInvalidArgument0);
    if (!(block->options & bvh::kOptionVertexAccess))
        return raise(state, kExceptionUnsupportedDataAccess);
    const bvh::InputRecord* input = bvh::inputWithSbtIndex(*block, sbtGasIndex);
    if (!input)
        return raise(state, kExceptionInvalidArgument0 - 2);
    if (primitive - input->primitiveIndexOffset >= input->numPrimitives)
        raise(state, kExceptionInvalidArgument0 - 1);
}

void checkInstance(RayState* state, uint64_t ias, uint32_t index) {
    const bvh::BlockHeader* block = blockOf(ias, kTagIas);
    if (!block)
        return raise(state, kExceptionInvalidArgument0);
    if (!(block->options & bvh::kOptionInstanceAccess))
        return raise(state, kExceptionUnsupportedDataAccess);
    if (index >= block->numPrimitives)
        raise(state, kExceptionInvalidArgument0 - 1);
}

void raiseWithoutPath(RayState* state, int32_t code, const ExceptionInfo& info) {
    state->hit.transformCount = 0;
    raise(state, code, &info);
}

void checkFinite(RayState* state) {
    ExceptionInfo info{};
    for (int i = 0; i < 3; ++i) {
        info.ray[i] = state->worldOrigin[i];
        info.ray[3 + i] = state->worldDirection[i];
    }
    info.ray[6] = state->tmin;
    info.ray[7] = state->tmax;
    info.ray[8] = state->time;
    for (float value : info.ray)
        if (!std::isfinite(value)) {
            info.line = state->line;
            raiseWithoutPath(state, kExceptionInvalidRay, info);
        }
}

void checkRayFlags(RayState* state) {
    constexpr uint32_t kAnyHit =
        kRayDisableAnyHit | kRayEnforceAnyHit | kRayCullDisabledAnyHit | kRayCullEnforcedAnyHit;
    constexpr uint32_t kFaces = kRayCullBack | kRayCullFront;
    ExceptionInfo info{};
    info.line = state->line;
    if (__builtin_popcount(state->rayFlags & kAnyHit) > 1 || (state->rayFlags & kFaces) == kFaces)
        raiseWithoutPath(state, kExceptionInvalidArgument0, info);
}

} // namespace

void checkRay(RayState* state) {
    checkFinite(state);
    checkRayFlags(state);
    // Eight bits are used here, as the manual requires; some processors use only four.
    if (state->sbtOffset > 15 || state->sbtStride > 15)
        note(*state->launch, &LaunchNotes::wideSbt);
}

bool fitsBuiltin(const GroupEntry& group, const bvh::BlockHeader* block, uint32_t sbtGasIndex) {
    return fitsBuiltin(group.builtinPrimitive, block, sbtGasIndex);
}

void checkStack(RayState* state) {
    const auto frame = reinterpret_cast<uint64_t>(__builtin_frame_address(0));
    if (frame < state->thread->stackLimit && state->launch->raise)
        raise(state, kExceptionStackOverflow);
}

void checkCallable(RayState* state, uint32_t sbtIndex, uint32_t call) {
    const LaunchState& launch = *state->launch;
    const bool continuation = call & 1;
    const uint32_t passed = call >> 8;
    ExceptionInfo info{};
    info.sbtOffset = sbtIndex;
    if (launch.sbt.callableBase == 0 || sbtIndex >= launch.sbt.callableCount)
        return raise(state, kExceptionCallableInvalidSbt, &info);
    const GroupEntry* group =
        resolve(launch, SbtRecords::callable(launch, sbtIndex), kGroupCallables).group;
    const void* code = group ? group->code[continuation ? kRoleContinuation : kRoleDirect] : nullptr;
    if (!code)
        return raise(state,
                     continuation ? kExceptionNoContinuationCallable : kExceptionNoDirectCallable,
                     &info);
    const uint32_t expected = group->callableWords[continuation];
    if (expected == passed)
        return;
    info = {};
    info.expectedWords = expected;
    info.passedWords = passed;
    info.callableIndex = sbtIndex;
    info.callableName = group->callableNames[continuation];
    info.line = state->thread->line;
    raise(state, kExceptionParameterMismatch, &info);
}

void checkAccess(RayState* state, uint32_t kind, uint64_t handle, uint32_t first, uint32_t second) {
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
        const bvh::BlockHeader* block = blockOf(handle, kTagGas);
        if (!block || bvh::kindOf(block->type) == bvh::BlockType::kInstances)
            raise(state, kExceptionInvalidArgument0);
        return;
    }
    default:
        return;
    }
}

void checkPayload(RayState* state, uint32_t type) {
    if (state->payloadType != type)
        raise(state, kExceptionPayloadType);
}

} // namespace sunstone::devlib
