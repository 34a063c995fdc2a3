// SPDX-License-Identifier: Apache-2.0
// Checks of a module that need constant propagation: payload slots, counts and types that are not
// plain constants in the text.
#pragma once

#include "compiler/compiler.h"

namespace sunstone::compiler {

// Compiles all programs of the module, for each payload type that they support, until the constants
// are known. Throws the errors found; missing symbols of other modules are not errors.
void checkByCompiling(const ptx::Module& module, const PipelineRules& rules,
                      const ModuleRules& moduleRules, const ModuleSummary& summary);

} // namespace sunstone::compiler
