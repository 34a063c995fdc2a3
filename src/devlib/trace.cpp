// SPDX-License-Identifier: Apache-2.0
#include "devlib/trace.h"

#include "base/log.h"
#include "base/readable.h"
#include "bvh/build/build.h"
#include "bvh/layout.h"
#include "bvh/motion/transforms.h"
#include "bvh/shapes/shape_geometry.h"
#include "bvh/shapes/shapes.h"
#include "bvh/walk/kernels.h"
#include "devlib/checks.h"
#include "devlib/launch_notes.h"
#include "devlib/records.h"
#include "devlib/trace_sets.h"

#include <algorithm>
#include <limits>

namespace sunstone::devlib {

namespace {

// Takes the place of missing callables: returns 0 in every register of a result.
uint64_t noCallable(RayState*) {
    asm volatile("pxor %%xmm0, %%xmm0" ::: "xmm0");
    return 0;
}

// The code of the callable, or null. Compiled code calls this for each call, not at the look-up of
// the callable: the data set here is then the callee's, whatever was looked up or called in
// between.
const void* findCallable(RayState* state, uint32_t sbtIndex, uint32_t call) {
    checkStack(state);
    const bool continuation = call & 1;
    const uint64_t record = SbtRecords::callable(*state->launch, sbtIndex);
    const GroupEntry* group = resolve(*state->launch, record, kGroupCallables).group;
    state->callableData = dataOf(record);
    return group ? group->code[continuation ? kRoleContinuation : kRoleDirect] : nullptr;
}

const void* callable(RayState* state, uint32_t sbtIndex, uint32_t call) {
    if (const void* const code = findCallable(state, sbtIndex, call))
        return code;
    const auto needed =
        call & 1 ? NeededProgram::kContinuationCallable : NeededProgram::kDirectCallable;
    note(*state->launch, &LaunchNotes::record, recordNote(needed, sbtIndex));
    return reinterpret_cast<const void*>(&noCallable);
}

const void* classicCallable(RayState* state, uint32_t id, uint32_t call) {
    if (const void* const code = findCallable(state, id, call))
        return code;
    if (const int32_t fault = ClassicRecords::callableFault(*state->launch))
        state->launch->raise(state, fault, nullptr);
    return reinterpret_cast<const void*>(&noCallable);
}

const void* checkedCallable(RayState* state, uint32_t sbtIndex, uint32_t call) {
    checkCallable(state, sbtIndex, call);
    return callable(state, sbtIndex, call);
}

// The block of a handle in mapped memory, or null.
const void* blockAt(uint64_t handle, HandleTag tag) {
    const auto* block = reinterpret_cast<const void*>(addressOf(handle));
    // Programs query the same structure many times.
    thread_local const void* known = nullptr;
    thread_local uint64_t epoch = 0;
    if (tagOf(handle) != tag)
        return nullptr;
    if ((block != known || epoch != readableEpoch()) &&
        !isReadable(block, sizeof(bvh::BlockHeader)))
        return nullptr;
    known = block;
    epoch = readableEpoch();
    return bvh::isBlock(block) ? block : nullptr;
}

void triangleVertices(uint64_t gas, uint32_t primitive, uint32_t sbtGasIndex, float time,
                      float* vertices) {
    const void* block = blockAt(gas, kTagGas);
    if (!block || !bvh::triangleVertices(block, primitive, sbtGasIndex, vertices, time))
        std::fill(vertices, vertices + 9, std::numeric_limits<float>::quiet_NaN());
}

void gasMotion(uint64_t gas, GasMotion* motion) {
    const void* block = blockAt(gas, kTagGas);
    const bvh::MotionOptions options = block ? bvh::motionOf(block) : bvh::MotionOptions{};
    *motion = {options.keys, options.begin, options.end};
}

void shapePoints(uint64_t gas, uint32_t shape, uint32_t primitive, uint32_t sbtGasIndex, float time,
                 float* points) {
    const void* block = blockAt(gas, kTagGas);
    if (!block || !bvh::shapePoints(block, shape, primitive, sbtGasIndex, time, points))
        std::fill(points, points + bvh::shapeFloats(shape),
                  std::numeric_limits<float>::quiet_NaN());
}

uint64_t instanceHandle(uint64_t ias, uint32_t index) {
    const void* block = blockAt(ias, kTagIas);
    if (!block || !(bvh::headerOf(block)->options & bvh::kOptionInstanceAccess))
        return 0;
    const void* record = bvh::instanceRecord(block, index);
    return record ? makeHandle(record, kTagInstance) : 0;
}

// See isTraversable.
bool leadsToMemory(uint64_t handle) {
    const auto* address = reinterpret_cast<const void*>(addressOf(handle));
    switch (tagOf(handle)) {
    case kTagGas:
    case kTagIas:
        return isReadable(address, sizeof(bvh::BlockHeader));
    case kTagStatic:
    case kTagMatrixMotion:
    case kTagSrtMotion:
        return bvh::isReadableTransform(handle);
    case kTagVisit:
        return isReadable(address, sizeof(VisitNode));
    case kTagInstance: // of the classic API; others pass it by
        return isReadable(address, sizeof(InstanceRecord));
    default:
        return false;
    }
}

const TraceSet& chosenSet() {
    switch (bvh::chosenIsa()) {
    case bvh::Isa::kAvx512:
        return kTraceAvx512;
    case bvh::Isa::kAvx2:
        return kTraceAvx2;
    default:
        return kTraceBaseline;
    }
}

} // namespace

TraceVariant selectTrace(const TraceFeatures& features) {
    const TraceSet& set = chosenSet();
    if (features.classic)
        return {set.traceClassic, set.batchClassic, set.reportClassic, classicCallable,
                set.visitChild};
    if (features.checked)
        return {kTraceChecked.traceGraph, kTraceChecked.batchGraph, kTraceChecked.report,
                checkedCallable, nullptr};
    if (features.instancing)
        return {set.traceGraph, set.batchGraph, set.report, callable, nullptr};
    return {set.traceGas, set.batchGas, set.report, callable, nullptr};
}

void bindTrace(LaunchState& launch, const TraceFeatures& features) {
    const TraceVariant variant = selectTrace(features);
    launch.trace = variant.trace;
    launch.report = variant.report;
    launch.callable = variant.callable;
    launch.visitChild = variant.visitChild;
    launch.triangleVertices = triangleVertices;
    launch.instanceHandle = instanceHandle;
    launch.checkAccess = checkAccess;
    launch.checkPayload = checkPayload;
    launch.gasMotion = gasMotion;
    launch.shapePoints = shapePoints;
}

bool isTraversable(uint64_t handle) {
    // The handles stay the same from one tile of a launch to the next. There are slots for the
    // usual number of transforms of a scene: a miss costs system calls, at worst for every ray.
    constexpr size_t kKnown = 1024;
    thread_local uint64_t known[kKnown] = {};
    thread_local uint64_t epoch = 0;
    if (epoch != readableEpoch())
        std::fill_n(known, kKnown, 0);
    epoch = readableEpoch();
    uint64_t& slot = known[handle * 0x9E3779B97F4A7C15u >> 54];
    static_assert(kKnown == 1u << (64 - 54));
    if (slot == handle && handle != 0)
        return true;
    if (!leadsToMemory(handle))
        return false;
    slot = handle;
    return true;
}

} // namespace sunstone::devlib
