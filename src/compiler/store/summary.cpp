// SPDX-License-Identifier: Apache-2.0
// Serialises summaries of modules, and makes their keys.
#include "compiler/compiler.h"
#include "compiler/store/build_id.h"
#include "compiler/store/bytes.h"
#include "compiler/store/digest.h"

namespace sunstone::compiler {

namespace {

constexpr uint32_t kMagic = 0x4d4d5553; // "SUMM"

} // namespace

std::string ModuleSummary::serialize() const {
    ByteWriter out;
    out.number(kMagic);
    out.number(uint32_t(programs.size()));
    for (const Program& program : programs) {
        // Names every field, so that a new field does not compile until it is stored.
        const auto& [name, kind, payloadWords, traces, callsContinuation, words, payloadTypes,
                     statements, estimatedStack] = program;
        out.text(name);
        for (const uint32_t value :
             {uint32_t(kind), payloadWords, uint32_t(traces), uint32_t(callsContinuation), words,
              payloadTypes, statements, estimatedStack})
            out.number(value);
    }
    out.wide(launchParamsSize);
    out.wide(constantBytes);
    out.number(selfContained);
    out.number(mayRecurse);
    out.number(mayWaitForOthers);
    out.text(remarks);
    return out.take();
}

bool ModuleSummary::deserialize(std::string_view bytes) {
    ByteReader in(bytes);
    if (in.number() != kMagic)
        return false;
    programs.clear();
    for (uint32_t left = in.number(); left != 0 && in.good(); --left) {
        Program program;
        program.name = in.text();
        const uint32_t kind = in.number();
        if (kind == uint32_t(ProgramKind::kNone) || kind > uint32_t(kLastProgramKind))
            return false;
        program.kind = ProgramKind(kind);
        program.payloadWords = in.number();
        program.traces = in.number() != 0;
        program.callsContinuation = in.number() != 0;
        program.parameterWords = in.number();
        program.payloadTypes = in.number();
        program.statements = in.number();
        program.estimatedStack = in.number();
        programs.push_back(std::move(program));
    }
    launchParamsSize = in.wide();
    constantBytes = in.wide();
    selfContained = in.number() != 0;
    mayRecurse = in.number() != 0;
    mayWaitForOthers = in.number() != 0;
    remarks = in.text();
    return in.finished();
}

std::string summaryKeyOf(const Source& source, const PipelineRules& rules,
                         const ModuleRules& moduleRules) {
    Digest digest;
    digest.add(buildId());
    digest.add("summary");
    digest.add(source.digest());
    addRules(digest, rules);
    addRules(digest, moduleRules);
    return digest.take();
}

} // namespace sunstone::compiler
