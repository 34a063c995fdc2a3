// SPDX-License-Identifier: Apache-2.0
// Constants that pass through a thread's own memory: compilers that do not optimise store arguments
// of inlined functions and load them right away. Memory with accesses at variable places stays
// memory (passes/optimizer.h), but the operands of some intrinsics have to be constants.
#pragma once

#include <llvm/IR/Constants.h>

namespace sunstone::compiler {

// The constant, or the constant that the block of a load stored there last; else null.
const llvm::ConstantInt* storedConstant(const llvm::Value* value);

} // namespace sunstone::compiler
