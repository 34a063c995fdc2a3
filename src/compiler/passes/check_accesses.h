// SPDX-License-Identifier: Apache-2.0
// Code for the memory checker: before each load, store and atomic of device code a call passes the
// access to the checker (devlib::CheckedAccess). The translator marks the accesses of the PTX. The
// pass turns the marks into calls; it runs after registers and local variables have become values.
// Accesses to variables by name at offsets within them, and accesses that the compiler adds, are
// not marked. If the checker is off (base/config.h: checks("memory")), there are no marks or calls.
#pragma once

#include "compiler/translate/unit.h"

#include <llvm/IR/PassManager.h>

namespace sunstone::compiler {

// One PTX access; a vector access becomes several LLVM accesses, each marked.
struct AccessMark {
    uint32_t number = 0; // of the PTX access in its unit
    uint32_t bytes = 0;  // of the whole access
    uint8_t kind = 0;    // devlib::AccessVerb
    uint8_t space = 0;   // devlib::AccessSpace
    uint32_t ptxLine = 0;
    std::string function; // of the PTX
    std::string place;    // "file:line:column", empty if not known
};

// offset: bytes from the start of the access to this part.
void markAccess(llvm::Instruction& access, const AccessMark& mark, uint32_t offset);

// Turns all marks of a module into calls.
struct CheckAccessesPass : llvm::PassInfoMixin<CheckAccessesPass> {
    explicit CheckAccessesPass(bool isKernels) : isKernels(isKernels) {}
    llvm::PreservedAnalyses run(llvm::Module& module, llvm::ModuleAnalysisManager&);
    static bool isRequired() { return true; }
    bool isKernels; // else programs: whose check function the code calls
};

// Whether an instruction is a call that the pass has added. It writes no memory of the program.
bool isAccessCheck(const llvm::Instruction& instruction);

} // namespace sunstone::compiler
