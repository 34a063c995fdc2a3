// SPDX-License-Identifier: Apache-2.0
// OptiX 7 names in engine messages.
#include "api/optix7/wording.h"

#include "base/error.h"
#include "devlib/abi.h"

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

} // namespace

const engine::Wording& wording() {
    static const engine::Wording words = {
        exceptionName,
        "optixTrace with an SBT offset or stride above 15: on processors that use four bits of "
        "them it finds other records",
        "a ray came to a traversable that traversableGraphFlags of the pipeline compile options rule "
        "out, and passed it by",
        "a ray came to motion keys or a motion transform, which a pipeline compiled without "
        "usesMotionBlur rules out, and passed them by",
        deepGraph, "optixSbtRecordPackHeader"};
    return words;
}

} // namespace sunstone::optix7
