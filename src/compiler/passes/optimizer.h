// SPDX-License-Identifier: Apache-2.0
// The pass list. PTX arrives optimised by the compiler that wrote it, so the list is short: undo
// the detour through registers in memory, inline, combine, and clean up.
#pragma once

#include "compiler/translate/unit.h"

#include <llvm/Target/TargetMachine.h>

namespace sunstone::compiler {

class Optimizer {
public:
    Optimizer(Unit& unit, llvm::TargetMachine& machine, OptLevel level);
    ~Optimizer();

    void promote(); // registers and local arrays out of memory
    void inlineAlways();
    void optimize(); // everything else
    void dump(const char* stage);

    // For one function of lockstep.h: loops and branches in the forms that it can read; and what
    // was written, places made values again.
    void simplifyControl(llvm::Function& function);
    void finishLockstep(llvm::Function& function);
    void forget(llvm::Function& function); // before it is erased

private:
    struct Managers;
    Unit& unit_;
    OptLevel level_;
    std::unique_ptr<Managers> managers_;
    unsigned number_;
    unsigned stage_ = 0;
};

} // namespace sunstone::compiler
