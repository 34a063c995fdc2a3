// SPDX-License-Identifier: Apache-2.0
// LLVM's code generator for functions of any length. Some of its passes take time by the square of
// a block's length, so long blocks are split before instructions are selected.
#pragma once

#include <llvm/IR/LegacyPassManager.h>
#include <llvm/Support/raw_ostream.h>
#include <llvm/Target/TargetMachine.h>

namespace sunstone::compiler {

// Sets limits of LLVM's own passes, which are settings of the process. Call before the first
// machine is created.
void limitCodeGenerator();

// Adds the passes that write `machine`'s object code for `module`. False if it cannot write any.
bool addCodeGenerator(llvm::TargetMachine& machine, const llvm::Module& module,
                      llvm::legacy::PassManager& passes, llvm::raw_pwrite_stream& stream);

} // namespace sunstone::compiler
