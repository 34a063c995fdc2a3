// SPDX-License-Identifier: Apache-2.0
// The table of `_optix_*` functions that PTX may call: operands, where they are legal, and their
// lowering. One table for all releases of the API, 7.0 to 9.1. No LLVM here, because module
// inspection uses it as well. Read next: optix7/lower.cpp, which replaces the calls.
#pragma once

#include "compiler/flavor.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace sunstone::compiler {

// Values of Intrinsic::op.
enum class IntrinsicOp : uint8_t {
    kTrace,      // number = payload words of the old forms, -1: operand
    kSetPayload, // number = slot of the old forms, -1: operand
    kGetPayload, // same
    kSetPayloadTypes,
    kUndefined,
    kRayField,        // number = offset in RayState
    kLaunchIndex,     // number = component
    kLaunchDimension, // number = component
    kBarycentrics,
    kSbtData,
    kReport, // number = attributes
    kTerminate,
    kIgnore,
    kThrow, // number = details
    kExceptionCode,
    kExceptionDetail, // number = index
    kExceptionInfo,   // number = offset in ExceptionInfo of the first result
    kPrimitiveTypeOfKind,
    kBackfaceOfKind,
    kTransformHandle,
    kTransformType,
    kTransformPointer, // number = HandleTag expected; result is the address
    kInstanceMatrix,   // number = offset in InstanceRecord; result is its address
    kInstanceField,    // number = offset in InstanceRecord; result is its value
    kTriangleVertices,
    kShapePoints, // number = OptixPrimitiveType
    kInstanceHandle, // of the n-th instance of an instance acceleration structure
    kFootprint,        // number = form of the sampling call
    kGasMotion,      // number = offset in GasMotion
    kCallable,         // number = 1: continuation
    kLater,            // known, not available yet
};

constexpr std::string_view kIntrinsicPrefix = "_optix_";

inline bool isIntrinsicName(std::string_view name) {
    return name.starts_with(kIntrinsicPrefix);
}

// The entry for a full name ("_optix_get_payload"), null if there is none.
const Intrinsic* findIntrinsic(std::string_view fullName);

inline IntrinsicOp opOf(const Intrinsic& intrinsic) {
    return IntrinsicOp(intrinsic.op);
}

} // namespace sunstone::compiler
