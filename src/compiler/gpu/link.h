// SPDX-License-Identifier: Apache-2.0
// Links the run-time for GPUs to the programs of a pipeline. Its bitcode has the traversal loops
// for every kind of graph and primitive; only the functions in use are read.
#pragma once

#include <llvm/IR/Module.h>
#include <llvm/Target/TargetMachine.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sunstone::compiler {

// Adds the run-time's definitions of the functions that `module` declares, and what these call, for
// the given values of the run-time's `extern const uint32_t` variables. Code that the values
// exclude is not read.
void linkGpuRuntime(llvm::Module& module, llvm::TargetMachine& machine, std::string_view bitcode,
                    const std::vector<std::pair<std::string, uint32_t>>& constants);

} // namespace sunstone::compiler
