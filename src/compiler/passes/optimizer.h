// SPDX-License-Identifier: Apache-2.0
// The pass list. PTX was already optimised when it was written, so the list is short: promote
// registers from memory, inline, combine, and clean up.
#pragma once

#include "compiler/translate/unit.h"

#include <llvm/Target/TargetMachine.h>

namespace sunstone::compiler {

// An access to null or a call of it is a fault at run time. Call it before passes run: without it,
// LLVM removes code on the way to a null that it knows.
void keepNullAccesses(llvm::Module& module);

class Optimizer {
public:
    Optimizer(Unit& unit, llvm::TargetMachine& machine, OptLevel level);
    ~Optimizer();

    void promote(); // registers and local arrays from memory to values
    // Replaces loads by values stored before, also in memory whose address is passed to calls.
    // Unoptimised code passes its operands in memory, and lowering for GPUs needs the constants
    // among them.
    void forwardStores();
    void inlineAlways();
    void optimize(); // all further passes
    void dump(const char* stage);

    // For one function of lockstep.h: simplifyControl brings loops and branches into the forms that
    // LockstepPlan reads; finishLockstep promotes the places of the emitted code to values.
    void simplifyControl(llvm::Function& function);
    void finishLockstep(llvm::Function& function, bool isLong);
    void forget(llvm::Function& function); // before it is erased

private:
    struct Managers;
    // Drops all analyses, because lowering changes functions between the passes without notifying
    // the pass manager.
    void begin();
    Unit& unit_;
    OptLevel level_;
    std::unique_ptr<Managers> managers_;
    unsigned number_;
    unsigned stage_ = 0;
};

} // namespace sunstone::compiler
