// SPDX-License-Identifier: Apache-2.0
// Checks of options that several entry points take.
#pragma once

#include "api/optix7/shell.h"

namespace sunstone::optix7 {

// Checks and copies pipeline compile options for a context of an ABI; throws an Error naming the
// field.
CompileOptions checkCompileOptions(const OptixPipelineCompileOptions* options, Abi abi);

// Checks and copies a payload type; `where` names it in messages.
compiler::PayloadType checkPayloadType(const OptixPayloadType& type, const std::string& where);

// Throws if the level is no enumerator of the ABI.
void checkDebugLevel(OptixCompileDebugLevel level, const char* parameter, Abi abi);

} // namespace sunstone::optix7
