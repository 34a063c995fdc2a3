// SPDX-License-Identifier: Apache-2.0
// LLVM passes of our own.
#pragma once

#include <llvm/IR/PassManager.h>

namespace sunstone::compiler {

// Turns address arithmetic on integers into address arithmetic on pointers, if the integer comes
// from a known pointer. Without it, local arrays cannot be promoted to registers and alias analysis
// fails, because PTX computes addresses in integer registers.
class PointerPass : public llvm::PassInfoMixin<PointerPass> {
public:
    llvm::PreservedAnalyses run(llvm::Function& function, llvm::FunctionAnalysisManager&);
};

// Above this number of loops in a function, passes that compare each loop with the conditions
// before it take too long, and are left out.
constexpr unsigned kManyLoops = 256;

// Turns the translator's registers, which are memory where several regions of a function use them,
// into values. LLVM's pass for this walks over all later blocks for each register; this one walks
// over the blocks in which a register is live.
class RegisterPass : public llvm::PassInfoMixin<RegisterPass> {
public:
    llvm::PreservedAnalyses run(llvm::Function& function, llvm::FunctionAnalysisManager&);
};

} // namespace sunstone::compiler
