// SPDX-License-Identifier: Apache-2.0
#include "engine/module.h"

#include "base/error.h"
#include "engine/compile_cache.h"
#include "ptx/parse/parser.h"

namespace sunstone::engine {

const compiler::ModuleSummary::Program* Module::findProgram(std::string_view name) const {
    for (const auto& program : summary.programs)
        if (program.name == name)
            return &program;
    return nullptr;
}

namespace {

// Bound values must lie in the launch parameters, if the module has any.
void checkBoundValues(const compiler::ModuleRules& rules, uint64_t paramsSize) {
    for (size_t i = 0; i < rules.boundValues.size() && paramsSize != 0; ++i) {
        const compiler::BoundValue& value = rules.boundValues[i];
        if (value.offset > paramsSize || value.bytes.size() > paramsSize - value.offset)
            fail(Code::kInvalidValue, "boundValues[", i, "] covers ", value.bytes.size(),
                 " bytes from ", value.offset, " of a launch parameter variable of ", paramsSize);
    }
}

compiler::ModuleSummary check(const ptx::Module& tree, const compiler::PipelineRules& rules,
                              const compiler::ModuleRules& moduleRules,
                              const std::string& remarks) {
    compiler::ModuleSummary summary = compiler::inspect(tree, rules, moduleRules);
    summary.remarks = remarks + summary.remarks;
    return summary;
}

// Whether only the device's compiler knows some instruction. Other devices must not find this
// result in the cache.
bool hasForeign(const ptx::Module& tree) {
    for (const ptx::Function& function : tree.functions)
        for (const ptx::Statement& statement : function.body)
            if (statement.instruction.isForeign)
                return true;
    return false;
}

std::shared_ptr<const ptx::Module> parse(std::string_view text, Backend& backend,
                                         std::string& remarks) {
    ptx::Judge judge; // code for CPUs is made by this library alone
    if (!backend.sharesMemory())
        judge = [&](const ptx::Module& alone) { return backend.accepts(alone); };
    ptx::Diagnostics diagnostics;
    std::shared_ptr<const ptx::Module> tree = ptx::parse(text, diagnostics, judge);
    if (diagnostics.failed() || !tree)
        throw Error(Code::kInvalidPtx, diagnostics.format());
    remarks = diagnostics.format();
    return tree;
}

} // namespace

std::shared_ptr<Module> createModule(std::string_view text, const compiler::PipelineRules& rules,
                                     compiler::ModuleRules moduleRules, compiler::OptLevel optLevel,
                                     compiler::DebugLevel debugLevel,
                                     std::shared_ptr<CompileCache> cache, Backend& backend,
                                     std::string& feedback) {
    auto module = std::make_shared<Module>();
    const auto known = [&] {
        if (!cache || !cache->enabled())
            return false;
        module->source = std::make_shared<const compiler::Source>(text);
        std::string bytes;
        return cache->findModule(compiler::summaryKeyOf(*module->source, rules, moduleRules),
                                 bytes) &&
               module->summary.deserialize(bytes);
    };
    if (!known()) {
        const auto tree = parse(text, backend, feedback);
        module->source = std::make_shared<const compiler::Source>(tree);
        module->summary = check(*tree, rules, moduleRules, feedback);
        if (cache && !hasForeign(*tree))
            cache->insert(compiler::summaryKeyOf(*module->source, rules, moduleRules),
                          module->summary.serialize());
    }
    feedback = module->summary.remarks;
    checkBoundValues(moduleRules, module->summary.launchParamsSize);
    module->prepared = std::make_shared<PreparedCode>(std::move(cache));
    module->rules = rules;
    module->optLevel = optLevel;
    module->debugLevel = debugLevel;
    module->moduleRules = std::make_shared<const compiler::ModuleRules>(std::move(moduleRules));
    return module;
}

} // namespace sunstone::engine
