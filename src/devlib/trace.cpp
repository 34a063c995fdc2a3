// SPDX-License-Identifier: Apache-2.0
#include "devlib/trace.h"

#include "bvh/kernels.h"
#include "bvh/layout.h"
#include "devlib/sbt.h"
#include "devlib/trace_sets.h"

namespace sunstone::devlib {

// bvh has its own names for what the two share.
static_assert(sizeof(InstanceRecord) == sizeof(bvh::InstanceData));
static_assert(offsetof(InstanceRecord, worldToObject) ==
              offsetof(bvh::InstanceData, worldToObject));
static_assert(offsetof(InstanceRecord, child) == offsetof(bvh::InstanceData, child));
static_assert(offsetof(InstanceRecord, instanceId) == offsetof(bvh::InstanceData, instanceId));
static_assert(offsetof(InstanceRecord, index) == offsetof(bvh::InstanceData, index));
static_assert(uint64_t(kTagGas) == bvh::kGasTag && uint64_t(kTagIas) == bvh::kIasTag &&
              uint64_t(kTagStatic) == bvh::kStaticTransformTag &&
              uint64_t(kTagMask) == bvh::kTraversableTagMask);

namespace {

// Stands for callables that do not exist: returns 0 in every register a result may be in.
uint64_t noCallable(RayState*) {
    asm volatile("pxor %%xmm0, %%xmm0" ::: "xmm0");
    return 0;
}

// Compiled code asks at each call, not where a program looks the callable up: the data set here is
// then the callee's, whatever was looked up or called in between.
const void* callable(RayState* state, uint32_t sbtIndex, uint32_t continuation) {
    const SbtView& sbt = state->launch->sbt;
    const ResolvedRecord r = resolveRecord(*state->launch, sbt.callableBase, sbt.callableStride,
                                           sbt.callableCount, sbtIndex, kGroupCallables);
    const void* code = !r.group ? nullptr : continuation ? r.group->continuation : r.group->direct;
    state->callableData = dataOf(r.record);
    return code ? code : reinterpret_cast<const void*>(&noCallable);
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
    return {features.instancing ? set.traceGraph : set.traceGas, set.report, callable};
}

void bindTrace(LaunchState& launch, const TraceFeatures& features) {
    const TraceVariant variant = selectTrace(features);
    launch.trace = variant.trace;
    launch.report = variant.report;
    launch.callable = variant.callable;
}

} // namespace sunstone::devlib
