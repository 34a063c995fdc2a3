// SPDX-License-Identifier: Apache-2.0
// Sunstone's own LLVM passes.
#pragma once

#include <llvm/IR/PassManager.h>

namespace sunstone::compiler {

// Turns address arithmetic on integers into address arithmetic on pointers, if the integer comes
// from a known pointer. PTX computes addresses in integer registers, for which alias analysis and
// the promotion of local arrays to registers would fail.
class PointerPass : public llvm::PassInfoMixin<PointerPass> {
public:
    llvm::PreservedAnalyses run(llvm::Function& function, llvm::FunctionAnalysisManager&);
};

// Above this number of loops in a function, passes that compare each loop with the conditions
// before it take too long, and are left out.
constexpr unsigned kManyLoops = 256;

// Turns the translator's registers, which are in memory if several regions of a function use them,
// into SSA values. LLVM's pass for this visits all later blocks for each register; this one visits
// only the blocks in which the register is live.
class RegisterPass : public llvm::PassInfoMixin<RegisterPass> {
public:
    llvm::PreservedAnalyses run(llvm::Function& function, llvm::FunctionAnalysisManager&);
};

} // namespace sunstone::compiler
