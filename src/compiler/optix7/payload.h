// SPDX-License-Identifier: Apache-2.0
// The rules of payloads: the words that a program of each kind may read and write, and the type of
// a trace call. Without payload types every program may use the first numPayloadValues words.
// Source: OptiX API reference 7.4, sections 3.12.3.47 to 3.12.3.49, 3.12.4.19 and 5.30.2.6.
#pragma once

#include "base/error.h"
#include "compiler/compiler.h"

namespace sunstone::compiler {

enum class PayloadAccess : uint32_t { kRead = 1, kWrite = 2 };

// Whether the semantics of a word allow this access to programs of this kind (kNone: the caller of
// optixTrace). False for kinds without a payload.
bool allows(uint32_t semantics, ProgramKind kind, PayloadAccess access);

bool hasPayload(ProgramKind kind);

// Why a program of this kind may not access the slot; empty if it may. type null: untyped, with
// `untypedWords`.
std::string payloadProblem(ProgramKind kind, uint32_t slot, PayloadAccess access,
                           const PayloadType* type, unsigned untypedWords);

// A number for RayState::payloadType; the same for equal types, whatever module or pipeline they are
// in, and never 0, which stands for an untyped payload.
uint32_t payloadNumber(const PayloadType& type);

// The payload of a trace call with this type mask and word count.
struct TracePayload {
    const PayloadType* type = nullptr; // null: untyped
    sunstone::Code code = sunstone::Code::kOk;             // or what is wrong
    std::string problem;
};
TracePayload payloadOfTrace(uint32_t mask, uint32_t count, const ModuleRules& module,
                            const PipelineRules& pipeline);

// The error text (kPayloadTypeId) for a mask with types that the module lacks, or empty.
std::string unknownTypes(uint32_t mask, const ModuleRules& module);
// Mask 0 means all types of the module.
uint32_t supportedTypes(uint32_t mask, const ModuleRules& module);

} // namespace sunstone::compiler
