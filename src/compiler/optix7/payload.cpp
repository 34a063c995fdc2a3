// SPDX-License-Identifier: Apache-2.0
// See payload.h.
#include "compiler/optix7/payload.h"

#include "compiler/optix7/program_kind.h"

#include <algorithm>
#include <bit>

namespace sunstone::compiler {

namespace {

// Where the two bits of a kind are in a word of OptixPayloadSemantics; -1 without any.
int shiftOf(ProgramKind kind) {
    switch (kind) {
    case ProgramKind::kNone: return 0;
    case ProgramKind::kClosestHit: return 2;
    case ProgramKind::kMiss: return 4;
    case ProgramKind::kAnyHit: return 6;
    case ProgramKind::kIntersection: return 8;
    default: return -1;
    }
}

TracePayload wrong(sunstone::Code code, std::string problem) {
    TracePayload result;
    result.code = code;
    result.problem = std::move(problem);
    return result;
}

} // namespace

bool hasPayload(ProgramKind kind) {
    return kind != ProgramKind::kNone && shiftOf(kind) >= 0;
}

bool allows(uint32_t semantics, ProgramKind kind, PayloadAccess access) {
    const int shift = shiftOf(kind);
    return shift >= 0 && (semantics >> shift & uint32_t(access)) != 0;
}

std::string payloadProblem(ProgramKind kind, uint32_t slot, PayloadAccess access,
                           const PayloadType* type, unsigned untypedWords) {
    if (!type)
        return slot < untypedWords
                   ? std::string()
                   : message("payload slot ", slot, " of ", untypedWords,
                             " (numPayloadValues of the pipeline compile options)");
    if (slot >= type->words.size())
        return message("payload slot ", slot, " of ", type->words.size(),
                       " (numPayloadValues of the payload type)");
    if (hasPayload(kind) && !allows(type->words[slot], kind, access))
        return message("the payload type does not let a ", prefixOf(kind), " program ",
                       access == PayloadAccess::kRead ? "read" : "write", " payload slot ", slot,
                       " (semantics ", type->words[slot], ")");
    return {};
}

uint32_t payloadNumber(const PayloadType& type) {
    uint32_t hash = 2166136261u; // FNV-1a
    for (uint32_t word : type.words)
        hash = (hash ^ word) * 16777619u;
    hash = (hash ^ uint32_t(type.words.size())) * 16777619u;
    return hash ? hash : 1;
}

TracePayload payloadOfTrace(uint32_t mask, uint32_t count, const ModuleRules& module,
                            const PipelineRules& pipeline) {
    const auto& types = module.payloadTypes;
    if (types.empty()) {
        if (mask != 0)
            return wrong(sunstone::Code::kPayloadTypeId,
                         message("payload type ", mask, ", but the module has no payload types"));
        if (count > pipeline.optix7.numPayloadValues)
            return wrong(sunstone::Code::kInvalidPayloadAccess,
                         message(count, " payload values of ", pipeline.optix7.numPayloadValues,
                                 " (numPayloadValues of the pipeline compile options)"));
        return {};
    }
    if (mask == 0 && types.size() > 1)
        return wrong(sunstone::Code::kPayloadTypeResolution,
                     message("the call names no payload type, and the module has ", types.size()));
    const unsigned index = mask == 0 ? 0 : unsigned(std::countr_zero(mask));
    if (!std::has_single_bit(mask == 0 ? 1u : mask) || index >= types.size())
        return wrong(sunstone::Code::kPayloadTypeId,
                     message("payload type ", mask, " is not one of the module's ", types.size()));
    if (count != types[index].words.size())
        return wrong(sunstone::Code::kPayloadTypeMismatch,
                     message(count, " payload values, but payload type ", index, " has ",
                             types[index].words.size()));
    TracePayload result;
    result.type = &types[index];
    return result;
}

std::string unknownTypes(uint32_t mask, const ModuleRules& module) {
    if ((mask & ~supportedTypes(0, module)) == 0)
        return {};
    return message("payload types ", mask, " are not all among the module's ",
                   module.payloadTypes.size());
}

uint32_t supportedTypes(uint32_t mask, const ModuleRules& module) {
    return mask == 0 ? (1u << module.payloadTypes.size()) - 1 : mask;
}

} // namespace sunstone::compiler
