// SPDX-License-Identifier: Apache-2.0
// A device module: a checked text and its contents. Machine code is made when a pipeline is
// created, and only for programs that the pipeline can call. The list of contents is cached, too: a
// text that any process has checked before is parsed only when a part of it is compiled.
#pragma once

#include "compiler/compiler.h"
#include "engine/backend.h"
#include "engine/context.h"
#include "engine/prepared_code.h"

#include <memory>
#include <string>

namespace sunstone::engine {

struct Module {
    std::shared_ptr<const compiler::Source> source;
    compiler::ModuleSummary summary;
    compiler::PipelineRules rules;
    std::shared_ptr<const compiler::ModuleRules> moduleRules;
    compiler::OptLevel optLevel = compiler::OptLevel::k3;
    compiler::DebugLevel debugLevel = compiler::DebugLevel::kMinimal;

    bool forCpu = true; // else only the back end compiles programs, with their pipelines
    std::shared_ptr<PreparedCode> prepared; // machine code made so far; never null

    // The program of that name, or null.
    const compiler::ModuleSummary::Program* findProgram(std::string_view name) const;
};

// Parses and checks `text` (up to its first NUL). Throws Error with a compile code; its text is the
// full list of diagnostics. `feedback` receives warnings. `cache` (may be null) keeps the module's
// summary and code beyond its life. Instructions that are unknown here are valid if the back end's
// compiler accepts them.
std::shared_ptr<Module> createModule(std::string_view text, const compiler::PipelineRules& rules,
                                     compiler::ModuleRules moduleRules,
                                     compiler::OptLevel optLevel, compiler::DebugLevel debugLevel,
                                     std::shared_ptr<CompileCache> cache, Backend& backend,
                                     std::string& feedback);

} // namespace sunstone::engine
