// SPDX-License-Identifier: Apache-2.0
// Code for the memory checker: before each load, store and atomic of device code comes a call that
// says what is about to be accessed (devlib::CheckedAccess). The translator marks the accesses that
// the PTX makes; the pass, which runs when registers and local variables are values, turns the
// marks into calls. Accesses to variables by name at offsets within them are not marked, nor is
// what the compiler itself adds. Without the checker (base/config.h: checks("memory")) there are
// neither marks nor calls.
#pragma once

#include "compiler/translate/unit.h"

#include <llvm/IR/PassManager.h>

namespace sunstone::compiler {

// One PTX access; a vector access becomes several accesses of LLVM, each marked.
struct AccessMark {
    uint32_t number = 0; // of the PTX access in its unit
    uint32_t bytes = 0;  // of the whole access
    uint8_t kind = 0;    // devlib::AccessVerb
    uint8_t space = 0;   // devlib::AccessSpace
    uint32_t ptxLine = 0;
    std::string function; // of the PTX
    std::string place;    // "file:line:column", empty if not known
};

// offset: of this part in the access.
void markAccess(llvm::Instruction& access, const AccessMark& mark, uint32_t offset);

// Turns all marks of a module into calls.
struct CheckAccessesPass : llvm::PassInfoMixin<CheckAccessesPass> {
    explicit CheckAccessesPass(bool isKernels) : isKernels(isKernels) {}
    llvm::PreservedAnalyses run(llvm::Module& module, llvm::ModuleAnalysisManager&);
    static bool isRequired() { return true; }
    bool isKernels; // else programs: whose check function the code calls
};

} // namespace sunstone::compiler
