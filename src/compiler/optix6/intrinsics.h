// SPDX-License-Identifier: Apache-2.0
// The table of `_rt_*` functions that classic PTX may call, and of the flavor's own functions that
// return addresses of variables. No LLVM here. Read next: optix6/lower.cpp.
#pragma once

#include "compiler/flavor.h"

#include <string>
#include <string_view>

namespace sunstone::compiler::optix6 {

// Values of Intrinsic::op.
enum class Op : uint8_t {
    kVariable,   // the address of a variable, named behind kVariablePrefix
    kTrace,      // number: TraceForm
    kBuffer,     // the address of an element; number: BufferForm
    kBufferSize, // number: BufferForm
    kCallable,
    kPotential,
    kReport,
    kIgnore,
    kTerminate,
    kChild,
    kTransform, // of a point, vector or normal
    kMatrix,    // written to memory
    kPrimitive,
    kTriangleHit, // number: TriangleQuestion
    kBarycentrics,
    kThrow,
    kExceptionCode,
    kPrintActive,
    kTextureHandle,
    kLaunchIndex,     // number: component
    kLaunchDimension, // number: component
    kUndefined,
    kLater, // known, not available yet
};

enum TraceForm : int { kTraceMask = 1, kTraceTime = 2 };
enum BufferForm : int { kBufferVariable, kBufferId };
enum TriangleQuestion : int { kIsTriangle, kIsBackFace, kIsFrontFace };

constexpr std::string_view kPrefix = "_rt_";
constexpr std::string_view kVariablePrefix = "_rti_variable_";

// The entry for a full name, null if there is none.
const Intrinsic* find(std::string_view fullName);

} // namespace sunstone::compiler::optix6
