// SPDX-License-Identifier: Apache-2.0
// Program kinds by name prefix.
#include "compiler/optix7/program_kind.h"

namespace sunstone::compiler {

namespace {

struct KindPrefix {
    ProgramKind kind;
    const char* prefix;
};

constexpr KindPrefix kPrefixes[] = {
    {ProgramKind::kRaygen, "__raygen__"},
    {ProgramKind::kIntersection, "__intersection__"},
    {ProgramKind::kAnyHit, "__anyhit__"},
    {ProgramKind::kClosestHit, "__closesthit__"},
    {ProgramKind::kMiss, "__miss__"},
    {ProgramKind::kDirectCallable, "__direct_callable__"},
    {ProgramKind::kContinuationCallable, "__continuation_callable__"},
    {ProgramKind::kException, "__exception__"},
};

} // namespace

ProgramKind programKind(std::string_view functionName) {
    for (const KindPrefix& entry : kPrefixes)
        if (functionName.starts_with(entry.prefix))
            return entry.kind;
    return ProgramKind::kNone;
}

const char* prefixOf(ProgramKind kind) {
    for (const KindPrefix& entry : kPrefixes)
        if (entry.kind == kind)
            return entry.prefix;
    return "";
}

} // namespace sunstone::compiler
