// SPDX-License-Identifier: Apache-2.0
// Pipelines on the CPU: machine code, the table of program addresses, and the stack they need.
#include "engine/cpu/backend.h"

#include <algorithm>

namespace sunstone::engine {
namespace {

// Stack sizes for traces of full depth, whose programs call callables that call callables.
PipelineLimits defaultLimits(const std::vector<std::shared_ptr<ProgramGroup>>& groups,
                             const std::vector<PipelineParts::Indices>& indices,
                             const compiler::Code& code, unsigned traceDepth) {
    unsigned raygen = 0, state = 0, traversal = 0, direct = 0, continuation = 0;
    const auto sizeOf = [&](size_t index) {
        return index == PipelineParts::kNone ? 0
                                                : code.programs()[index].stackSize + kRuntimeFrames;
    };
    for (size_t i = 0; i < groups.size(); ++i) {
        const PipelineParts::Indices& index = indices[i];
        if (groups[i]->kind == devlib::kGroupRaygen)
            raygen = std::max(raygen, sizeOf(index[devlib::kRoleMain]));
        else
            state = std::max(state, sizeOf(index[devlib::kRoleMain]));
        traversal = std::max(traversal, sizeOf(index[devlib::kRoleAnyHit]) + sizeOf(index[devlib::kRoleIntersection]));
        direct = std::max(direct, sizeOf(index[devlib::kRoleDirect]));
        continuation = std::max(continuation, sizeOf(index[devlib::kRoleContinuation]));
    }
    state += 2 * continuation;
    PipelineLimits limits;
    limits.directStackFromTraversal = limits.directStackFromState = 2 * direct;
    limits.continuationStack = raygen + 2 * continuation +
                               (std::max(traceDepth, 1u) - 1) * state + std::max(state, traversal);
    return limits;
}

// Stores the data of a callable that debug exceptions report.
void describeCallable(Pipeline& pipeline, const ProgramRef& ref, devlib::GroupEntry& entry,
                      unsigned continuation) {
    if (!ref)
        return;
    pipeline.callableNames.push_back(ref.function);
    entry.callableNames[continuation] = pipeline.callableNames.back().c_str();
    entry.callableWords[continuation] = ref.module->findProgram(ref.function)->parameterWords;
}

void fillTable(Pipeline& pipeline, const PipelineParts& parts) {
    const auto& groups = parts.groups;
    if (groups.empty())
        return;
    const auto byNumber = [](const auto& a, const auto& b) { return a->number < b->number; };
    const auto [first, last] = std::minmax_element(groups.begin(), groups.end(), byNumber);
    pipeline.firstGroup = (*first)->number;
    pipeline.groups.resize((*last)->number - pipeline.firstGroup + 1, devlib::GroupEntry{});
    pipeline.callableNames.reserve(2 * groups.size());
    for (size_t i = 0; i < groups.size(); ++i) {
        const ProgramGroup& group = *groups[i];
        devlib::GroupEntry& entry = pipeline.groups[group.number - pipeline.firstGroup];
        entry.kind = group.kind;
        entry.builtinPrimitive = group.builtinPrimitive;
        for (unsigned role = 0; role < devlib::kRoleCount; ++role)
            if (const size_t index = parts.indices[i][role]; index != PipelineParts::kNone)
                entry.code[role] = pipeline.code->programs()[index].address;
        describeCallable(pipeline, group.programs[devlib::kRoleDirect], entry, 0);
        describeCallable(pipeline, group.programs[devlib::kRoleContinuation], entry, 1);
    }
}

} // namespace

void cpu::compile(Pipeline& pipeline, const PipelineParts& parts) {
    const auto& groups = parts.groups;
    if (!parts.request.programs.empty()) {
        pipeline.code = compiler::compilePipeline(parts.request, parts.cache);
        pipeline.feedback = pipeline.code->feedback();
        pipeline.defaultLimits = defaultLimits(groups, parts.indices, *pipeline.code,
                                               pipeline.limits.get().maxTraceDepth);
    }
    fillTable(pipeline, parts);
}

} // namespace sunstone::engine
