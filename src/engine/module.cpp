// SPDX-License-Identifier: Apache-2.0
#include "engine/module.h"

#include "base/error.h"
#include "ptx/parser.h"

#include <algorithm>

namespace sunstone::engine {

const compiler::ModuleSummary::Program* Module::findProgram(std::string_view name) const {
    for (const auto& program : summary.programs)
        if (program.name == name)
            return &program;
    return nullptr;
}

namespace {

// Bound values must lie in the launch parameters, if the module has them at all.
void checkBoundValues(const compiler::ModuleRules& rules, uint64_t paramsSize) {
    for (size_t i = 0; i < rules.boundValues.size() && paramsSize != 0; ++i) {
        const compiler::BoundValue& value = rules.boundValues[i];
        if (value.offset > paramsSize || value.bytes.size() > paramsSize - value.offset)
            fail(Code::kInvalidValue, "boundValues[", i, "] covers ", value.bytes.size(),
                 " bytes from ", value.offset, " of a launch parameter variable of ", paramsSize);
    }
}

// The manual asks for the flag; without it user exceptions work here, but perhaps not elsewhere.
std::string remarkOnThrows(const ptx::Module& tree, const compiler::PipelineRules& rules) {
    if (rules.exceptionFlags & devlib::kFlagUser)
        return {};
    for (const ptx::Function& function : tree.functions)
        for (const ptx::Statement& statement : function.body)
            if (statement.instruction.target.name.starts_with("_optix_throw_exception_"))
                return message("warning: line ", statement.instruction.location.line, ": \"",
                               function.name,
                               "\" calls optixThrowException, but the exception flags lack USER\n");
    return {};
}

} // namespace

std::shared_ptr<Module> createModule(std::string_view text, const compiler::PipelineRules& rules,
                                     compiler::ModuleRules moduleRules,
                                     compiler::OptLevel optLevel, compiler::DebugLevel debugLevel,
                                     std::shared_ptr<compiler::ObjectStore> cache,
                                     std::string& feedback) {
    ptx::Diagnostics diagnostics;
    std::shared_ptr<const ptx::Module> tree = ptx::parse(text, diagnostics);
    if (diagnostics.failed() || !tree)
        throw Error(Code::kInvalidPtx, diagnostics.format());
    feedback = diagnostics.format();
    auto module = std::make_shared<Module>();
    module->tree = std::move(tree);
    module->prepared = std::make_shared<PreparedCode>(std::move(cache));
    module->rules = rules;
    module->optLevel = optLevel;
    module->debugLevel = debugLevel;
    module->summary = compiler::inspect(*module->tree, rules, moduleRules);
    checkBoundValues(moduleRules, module->summary.launchParamsSize);
    feedback += remarkOnThrows(*module->tree, rules);
    module->moduleRules = std::make_shared<const compiler::ModuleRules>(std::move(moduleRules));
    return module;
}

unsigned estimateStackSize(const Module& module, std::string_view program) {
    const ptx::Function* function = module.tree->findFunction(program);
    if (!function)
        return 0;
    uint64_t bytes = 32; // return address and saved registers
    for (const ptx::Variable& variable : function->variables)
        if (variable.space == ptx::Space::kLocal)
            bytes += variable.size;
    // Values that live across a trace or call are spilled: a share of the registers is a fair guess.
    const auto* summary = module.findProgram(program);
    bool calls = std::any_of(function->body.begin(), function->body.end(), [](const auto& s) {
        return s.kind == ptx::StatementKind::kInstruction && s.instruction.opcode == "call";
    });
    if (summary && summary->traces)
        bytes += std::min<uint64_t>(function->registers.size(), 64) * 4;
    else if (calls)
        bytes += std::min<uint64_t>(function->registers.size(), 16) * 4;
    return unsigned((bytes + 15) / 16 * 16);
}

} // namespace sunstone::engine
