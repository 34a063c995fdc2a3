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

} // namespace sunstone::compiler
