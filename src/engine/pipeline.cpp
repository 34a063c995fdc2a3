// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline.h"

#include "base/error.h"

#include <algorithm>
#include <cstring>
#include <map>

namespace sunstone::engine {
namespace {

// Programs used by several groups are compiled once.
class ProgramCollector {
public:
    static constexpr size_t kNone = ~size_t(0);

    size_t add(const ProgramRef& ref) {
        if (!ref)
            return kNone;
        auto key = std::make_pair(ref.module.get(), ref.function);
        auto [found, inserted] = index_.try_emplace(key, requests_.size());
        if (inserted) {
            const Module& module = *ref.module;
            requests_.push_back({module.tree, ref.function, module.optLevel, module.debugLevel});
        }
        return found->second;
    }
    std::vector<compiler::ProgramRequest> take() { return std::move(requests_); }

private:
    std::vector<compiler::ProgramRequest> requests_;
    std::map<std::pair<const Module*, std::string>, size_t> index_;
};

struct GroupIndices {
    size_t main, anyHit, intersection, direct, continuation;
};

uint64_t commonLaunchParamsSize(const std::vector<std::shared_ptr<ProgramGroup>>& groups,
                                const std::string& name) {
    uint64_t size = 0;
    for (const auto& group : groups)
        for (const ProgramRef* ref : {&group->main, &group->anyHit, &group->intersection,
                                      &group->direct, &group->continuation}) {
            uint64_t own = *ref ? ref->module->summary.launchParamsSize : 0;
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

void packSbtHeader(const ProgramGroup& group, void* header) {
    devlib::SbtHeader out = {};
    out.magic = devlib::kSbtMagic;
    out.group = group.number;
    out.kind = group.kind;
    std::memcpy(header, &out, sizeof(out));
}

std::shared_ptr<Pipeline> createPipeline(const std::vector<std::shared_ptr<ProgramGroup>>& groups,
                                         const compiler::PipelineRules& rules,
                                         const PipelineLimits& limits,
                                         compiler::ObjectStore* cache) {
    auto pipeline = std::make_shared<Pipeline>();
    pipeline->rules = rules;
    pipeline->limits = limits;
    pipeline->launchParamsSize = commonLaunchParamsSize(groups, rules.launchParams);

    ProgramCollector collector;
    std::vector<GroupIndices> indices;
    uint32_t highest = 0;
    for (const auto& group : groups) {
        indices.push_back({collector.add(group->main), collector.add(group->anyHit),
                           collector.add(group->intersection), collector.add(group->direct),
                           collector.add(group->continuation)});
        highest = std::max(highest, group->number);
        pipeline->hasAnyHit |= bool(group->anyHit);
        pipeline->hasIntersection |= bool(group->intersection);
    }

    compiler::PipelineRequest request;
    request.programs = collector.take();
    request.rules = rules;
    if (!request.programs.empty())
        pipeline->code = compiler::compilePipeline(request, cache);

    pipeline->groups.resize(highest + 1, devlib::GroupEntry{});
    pipeline->groupPresent.resize(highest + 1, 0);
    pipeline->groupKinds.resize(highest + 1, devlib::kGroupRaygen);
    auto address = [&](size_t index) -> const void* {
        return index == ProgramCollector::kNone ? nullptr
                                                : pipeline->code->programs()[index].address;
    };
    for (size_t i = 0; i < groups.size(); ++i) {
        devlib::GroupEntry& entry = pipeline->groups[groups[i]->number];
        entry.main = devlib::ProgramFn(address(indices[i].main));
        entry.anyHit = devlib::ProgramFn(address(indices[i].anyHit));
        entry.intersection = devlib::ProgramFn(address(indices[i].intersection));
        entry.direct = address(indices[i].direct);
        entry.continuation = address(indices[i].continuation);
        pipeline->groupPresent[groups[i]->number] = 1;
        pipeline->groupKinds[groups[i]->number] = groups[i]->kind;
    }
    return pipeline;
}

} // namespace sunstone::engine
