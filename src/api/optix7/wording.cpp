// SPDX-License-Identifier: Apache-2.0
// OptiX 7 names in engine messages.
#include "api/optix7/wording.h"

#include "base/error.h"
#include "devlib/records.h"

namespace sunstone::optix7 {
namespace {

const char* exceptionName(int32_t code) {
    switch (code) {
    case devlib::kExceptionUnsupportedPrimitive:
        return "primitive type not in usesPrimitiveTypeFlags";
    case devlib::kExceptionInvalidRay:
        return "infinity or NaN among the arguments of optixTrace";
    case devlib::kExceptionUnsupportedSingleGas:
        return "geometry acceleration structure traced directly, but traversableGraphFlags lack "
               "ALLOW_SINGLE_GAS";
    default:
        return nullptr;
    }
}

std::string deepGraph(unsigned declared) {
    return message("a traversable graph has more than the ", declared,
                   " levels of maxTraversableGraphDepth given to optixPipelineSetStackSize");
}

std::string deepTrace(unsigned limit) {
    return message("optixTrace was called below maxTraceDepth = ", limit,
                   " of OptixPipelineLinkOptions; those calls traced no ray and ran no program");
}

// What an SBT record is for, and how an OptixShaderBindingTable describes its array.
struct RecordUse {
    const char *need, *index, *group, *array, *effect;
    uint64_t base;
    uint32_t count;
};

RecordUse useOf(devlib::NeededProgram program, const devlib::SbtView& sbt) {
    switch (program) {
    case devlib::NeededProgram::kHit:
        return {"a hit",          "hit group record",      "hit group",
                "hitgroupRecord", "no program ran for it", sbt.hitBase,
                sbt.hitCount};
    case devlib::NeededProgram::kMiss:
        return {"a miss",     "miss record", "miss group", "missRecord", "no program ran for it",
                sbt.missBase, sbt.missCount};
    case devlib::NeededProgram::kDirectCallable:
        return {"optixDirectCall", "callables record", "group with a direct callable",
                "callablesRecord", "it returned 0",    sbt.callableBase,
                sbt.callableCount};
    default:
        return {"optixContinuationCall", "callables record", "group with a continuation callable",
                "callablesRecord",       "it returned 0",    sbt.callableBase,
                sbt.callableCount};
    }
}

std::string missingRecord(uint64_t note, const devlib::SbtView& sbt) {
    const RecordUse use = useOf(devlib::NeededProgram(note >> 32), sbt);
    const uint32_t index = uint32_t(note);
    const std::string need = message(use.need, " needs ", use.index, " ", index, ", ");
    const std::string effect =
        message("; ", use.effect, " (in validation mode the log names the launch index)");
    if (use.base == 0)
        return message(need, "but ", use.array, "Base is 0", effect);
    if (index >= use.count)
        return message(need, "but ", use.array, "Count is ", use.count, effect);
    return message(need, "whose header optixSbtRecordPackHeader packed for no ", use.group,
                   " of this pipeline", effect);
}

} // namespace

const engine::Wording& wording() {
    static const engine::Wording words = {
        exceptionName,
        "optixTrace with an SBT offset or stride above 15: on processors that use four bits of "
        "them it finds other records",
        "a ray came to a traversable that traversableGraphFlags of the pipeline compile options "
        "rule out, and passed it by",
        "a ray came to motion keys or a motion transform, which a pipeline compiled without "
        "usesMotionBlur rules out, and passed them by",
        deepGraph,
        deepTrace,
        missingRecord,
        "optixSbtRecordPackHeader"};
    return words;
}

} // namespace sunstone::optix7
