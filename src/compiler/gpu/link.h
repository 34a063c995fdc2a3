// SPDX-License-Identifier: Apache-2.0
// The run-time for GPUs beside the programs of a pipeline. Its bitcode has the walks through every
// kind of graph and primitive; read are the functions that are needed, once it is known which.
#pragma once

#include <llvm/IR/Module.h>
#include <llvm/Target/TargetMachine.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sunstone::compiler {

// Adds what `module` declares and the run-time defines, with what that reaches when the run-time's
// `extern const uint32_t` variables have these values; whatever they rule out is not even read.
void linkGpuRuntime(llvm::Module& module, llvm::TargetMachine& machine, std::string_view bitcode,
                    const std::vector<std::pair<std::string, uint32_t>>& constants);

} // namespace sunstone::compiler
