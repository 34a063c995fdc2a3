// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline.h"

#include "base/error.h"
#include "engine/module_tasks.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

namespace sunstone::engine {
namespace {

compiler::ProgramRequest requestOf(const ProgramRef& ref) {
    const Module& module = *ref.module;
    return {module.source,     ref.function,       ref.kind,        module.optLevel,
            module.debugLevel, module.moduleRules, ref.payloadType, module.prepared,
            module.summary.selfContained};
}

// Programs used by several groups are compiled once.
class ProgramCollector {
public:
    static constexpr size_t kNone = PipelineParts::kNone;

    size_t add(const ProgramRef& ref) {
        if (!ref)
            return kNone;
        auto key = std::make_tuple(ref.module.get(), ref.function, ref.kind, ref.payloadType);
        auto [found, inserted] = index_.try_emplace(key, requests_.size());
        if (inserted) {
            requests_.push_back(requestOf(ref));
        }
        return found->second;
    }
    std::vector<compiler::ProgramRequest> take() { return std::move(requests_); }

private:
    std::vector<compiler::ProgramRequest> requests_;
    std::map<std::tuple<const Module*, std::string, compiler::ProgramKind, int>, size_t> index_;
};

// Calls use(module) once for each module of the groups.
template <class Use>
void forEachModule(const std::vector<std::shared_ptr<ProgramGroup>>& groups, const Use& use) {
    std::set<const Module*> seen;
    for (const auto& group : groups)
        for (const ProgramRef& ref : group->programs)
            if (ref && seen.insert(ref.module.get()).second)
                use(*ref.module);
}

// Where values of two modules overlap, they must be equal.
void checkBoundValues(const std::vector<compiler::BoundValue>& values) {
    std::map<uint64_t, std::pair<uint8_t, const compiler::BoundValue*>> bytes;
    for (const compiler::BoundValue& value : values)
        for (size_t i = 0; i < value.bytes.size(); ++i) {
            const auto [entry, isNew] =
                bytes.try_emplace(value.offset + i, value.bytes[i], &value);
            if (!isNew && entry->second.first != value.bytes[i])
                fail(Code::kInvalidValue, "two modules bind byte ", value.offset + i,
                     " of the launch parameters to ", unsigned(entry->second.first), " (\"",
                     entry->second.second->annotation, "\") and ", unsigned(value.bytes[i]), " (\"",
                     value.annotation, "\")");
        }
}

// The use of constant memory: .const variables of all modules, and the launch parameters once.
void checkConstantMemory(const std::vector<std::shared_ptr<ProgramGroup>>& groups,
                         uint64_t launchParamsSize) {
    constexpr uint64_t kConstantMemory = 64 << 10;
    uint64_t bytes = launchParamsSize;
    forEachModule(groups, [&](const Module& module) { bytes += module.summary.constantBytes; });
    if (bytes > kConstantMemory)
        fail(Code::kOutOfConstantMemory, "the .const variables of all modules have ", bytes,
             " bytes together, more than ", kConstantMemory);
}

uint64_t commonLaunchParamsSize(const std::vector<std::shared_ptr<ProgramGroup>>& groups,
                                const std::string& name) {
    uint64_t size = 0;
    for (const auto& group : groups)
        for (const ProgramRef& ref : group->programs) {
            uint64_t own = ref ? ref.module->summary.launchParamsSize : 0;
            if (own == 0)
                continue;
            if (size != 0 && own != size)
                fail(Code::kInvalidLaunchParameter, "launch parameter variable '", name, "' has ",
                     size, " bytes in one module and ", own, " bytes in another");
            size = own;
        }
    return size;
}

} // namespace

void choosePayloadType(ProgramGroup& group, const compiler::PayloadType* wanted) {
    std::vector<ProgramRef*> programs;
    const bool typed = group.kind == devlib::kGroupHit || group.kind == devlib::kGroupMiss;
    for (ProgramRef& ref : group.programs)
        if (typed && ref && (wanted || !ref.module->moduleRules->payloadTypes.empty()))
            programs.push_back(&ref);
    if (programs.empty())
        return;
    // Index of the type among those the program supports, or -1.
    const auto find = [](const ProgramRef& ref, const compiler::PayloadType& type) {
        const auto& types = ref.module->moduleRules->payloadTypes;
        const uint32_t supported = ref.module->findProgram(ref.function)->payloadTypes;
        for (size_t i = 0; i < types.size(); ++i)
            if ((supported >> i & 1) && types[i] == type)
                return int(i);
        return -1;
    };
    std::vector<compiler::PayloadType> candidates;
    if (wanted) {
        candidates = {*wanted};
        for (const ProgramRef* ref : programs)
            if (find(*ref, *wanted) < 0)
                fail(Code::kPayloadTypeMismatch, "program \"", ref->function,
                     "\" does not support the payload type of ", wanted->words.size(),
                     " words that the program group options ask for");
    } else {
        for (const compiler::PayloadType& type : programs[0]->module->moduleRules->payloadTypes) {
            const bool known = std::find(candidates.begin(), candidates.end(), type) !=
                               candidates.end();
            if (!known && std::all_of(programs.begin(), programs.end(), [&](const ProgramRef* ref) {
                    return find(*ref, type) >= 0;
                }))
                candidates.push_back(type);
        }
        if (candidates.size() != 1)
            fail(Code::kPayloadTypeResolution, "the programs of the group (first \"",
                 programs[0]->function, "\") have ", candidates.size(),
                 " payload types in common; name one in the program group options");
    }
    for (ProgramRef* ref : programs)
        ref->payloadType = find(*ref, candidates[0]);
}

unsigned stackSizeOf(const ProgramRef& program) {
    const Module& module = *program.module;
    const unsigned frames =
        module.forCpu && module.summary.selfContained
            ? compiler::stackNeed(requestOf(program), module.rules)
            : module.findProgram(program.function)->estimatedStack;
    return frames + kRuntimeFrames;
}

void packSbtHeader(const ProgramGroup& group, void* header) {
    devlib::SbtHeader out = {};
    out.magic = devlib::kSbtMagic;
    out.group = group.number;
    out.kind = group.kind;
    std::memcpy(header, &out, sizeof(out));
}

std::shared_ptr<Pipeline> createPipeline(Context& context,
                                         const std::vector<std::shared_ptr<ProgramGroup>>& groups,
                                         const compiler::PipelineRules& rules,
                                         const PipelineLimits& limits,
                                         const compiler::Flavor* flavor) {
    auto pipeline = std::make_shared<Pipeline>();
    pipeline->rules = rules;
    pipeline->limits.update([&](PipelineLimits& set) { set = limits; });
    pipeline->launchParamsSize = commonLaunchParamsSize(groups, rules.launchParams);

    checkConstantMemory(groups, pipeline->launchParamsSize);
    forEachModule(groups, [&](const Module& module) {
        const auto& own = module.moduleRules->boundValues;
        pipeline->boundValues.insert(pipeline->boundValues.end(), own.begin(), own.end());
        pipeline->mayWaitForOthers |= module.summary.mayWaitForOthers;
    });
    checkBoundValues(pipeline->boundValues);

    ProgramCollector collector;
    const bool caches = context.cache && context.cache->enabled();
    PipelineParts parts{groups, {}, {}, caches ? context.cache.get() : nullptr};
    for (const auto& group : groups) {
        PipelineParts::Indices& indices = parts.indices.emplace_back();
        for (unsigned role = 0; role < devlib::kRoleCount; ++role)
            indices[role] = collector.add(group->programs[role]);
        pipeline->hasAnyHit |= bool(group->programs[devlib::kRoleAnyHit]);
        pipeline->hasIntersection |= bool(group->programs[devlib::kRoleIntersection]);
    }
    parts.request.programs = collector.take();
    parts.request.rules = rules;
    parts.request.flavor = flavor;
    context.backend->compile(*pipeline, parts);
    return pipeline;
}

} // namespace sunstone::engine
