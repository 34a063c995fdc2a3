// SPDX-License-Identifier: Apache-2.0
// Constants that pass through local memory: without optimisation, compilers store arguments of
// inlined functions and load them at once. Memory that is accessed at variable offsets is not
// promoted (passes/optimizer.h), but the operands of some intrinsics must be constants.
#pragma once

#include <llvm/IR/Constants.h>

namespace sunstone::compiler {

// The constant, or the constant that the block of a load stored there last; else null.
const llvm::ConstantInt* storedConstant(const llvm::Value* value);

} // namespace sunstone::compiler
