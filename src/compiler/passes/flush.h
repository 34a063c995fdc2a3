// SPDX-License-Identifier: Apache-2.0
// .ftz: subnormal operands and results of single instructions count as zeros of their sign. The
// translator marks each such operand and result by a call of `sunstone.flush`; here the calls
// become code. Read flush.cpp for how.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

constexpr const char* kFlushName = "sunstone.flush";

// Appended to the name of a function that runs with results flushed by the processor.
constexpr const char* kFlushedSuffix = ".flushed";

// Begins the names of the functions through which code in that mode calls what must run in the
// default one: the first argument is the callee.
constexpr const char* kLeavePrefix = "leave.";

// Makes all of a function run in the mode: its body moves to another one, which it calls. For code
// made from a function that lowerFlushes has moved.
void runFlushed(Unit& unit, llvm::Function& function);

// hasFma: the code generator needs no library function for fma.
void lowerFlushes(Unit& unit, bool hasFma);

} // namespace sunstone::compiler
