// SPDX-License-Identifier: Apache-2.0
// .ftz: subnormal operands and results of single instructions count as zeros of their sign. The
// translator marks each such operand and result with a call of `sunstone.flush`; this pass turns
// the calls into code. flush.cpp describes how.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

constexpr const char* kFlushName = "sunstone.flush";

// Appended to the name of a function that runs with results flushed by the processor.
constexpr const char* kFlushedSuffix = ".flushed";

// The function that holds the body of `function` after lowerFlushes.
llvm::Function& flushedOf(Unit& unit, llvm::Function& function);

// Prefix of the functions through which code in that mode calls code that needs the default mode:
// the first argument is the callee.
constexpr const char* kLeavePrefix = "leave.";

// Makes all of a function run in the mode: its body moves to another function, which it calls. For
// code made from a flushed body.
void runFlushed(Unit& unit, llvm::Function& function);

// hasFma: the code generator needs no library function for fma.
void lowerFlushes(Unit& unit, bool hasFma);

} // namespace sunstone::compiler
