// SPDX-License-Identifier: Apache-2.0
// LLVM passes of our own.
#pragma once

#include <llvm/IR/PassManager.h>

namespace sunstone::compiler {

// Turns address arithmetic on integers into address arithmetic on pointers, where the integer
// comes from a pointer we know: only then can local arrays be promoted to registers and accesses
// be told apart. PTX computes addresses in integer registers throughout.
class PointerPass : public llvm::PassInfoMixin<PointerPass> {
public:
    llvm::PreservedAnalyses run(llvm::Function& function, llvm::FunctionAnalysisManager&);
};

} // namespace sunstone::compiler
