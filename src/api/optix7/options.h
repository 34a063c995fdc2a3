// SPDX-License-Identifier: Apache-2.0
// Checks of options used by several entry points.
#pragma once

#include "api/optix7/shell.h"

namespace sunstone::optix7 {

// Checks and copies pipeline compile options for a context's ABI; throws an Error naming the field.
CompileOptions checkCompileOptions(const OptixPipelineCompileOptions* options, Abi abi);

// Checks and copies a payload type; `where` names it in messages.
compiler::PayloadType checkPayloadType(const OptixPayloadType& type, const std::string& where);

// The checked and copied inputs of a module; the caller keeps the text.
struct ModuleInput {
    CompileOptions options;
    compiler::PipelineRules rules;
    compiler::ModuleRules moduleRules;
    compiler::OptLevel optLevel = compiler::OptLevel::k3;
    compiler::DebugLevel debugLevel = compiler::DebugLevel::kMinimal;
};
ModuleInput checkModuleInput(const ApiCall& call, const OptixModuleCompileOptions* moduleOptions,
                             const OptixPipelineCompileOptions* pipelineOptions, const char* ptx);
std::shared_ptr<engine::Module> makeModule(const std::shared_ptr<DeviceContext>& owner,
                                           ModuleInput input, std::string_view ptx,
                                           std::string& feedback);

// Checks the register count and the levels in module options. Throws an Error naming the field.
void checkCompileLevels(const OptixModuleCompileOptions& options, const ApiCall& call);

// Throws if the level is not an enumerator of the ABI.
void checkDebugLevel(OptixCompileDebugLevel level, const char* parameter, Abi abi);

} // namespace sunstone::optix7
