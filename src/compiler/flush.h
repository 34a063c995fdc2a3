// SPDX-License-Identifier: Apache-2.0
// .ftz: subnormal operands and results of single instructions count as zeros of their sign. The
// translator marks each such operand and result by a call of `sunstone.flush`; here the calls
// become code. Read flush.cpp for how.
#pragma once

#include "compiler/unit.h"

namespace sunstone::compiler {

constexpr const char* kFlushName = "sunstone.flush";

// Appended to the name of a function that runs with results flushed by the processor.
constexpr const char* kFlushedSuffix = ".flushed";

// hasFma: the code generator needs no library function for fma.
void lowerFlushes(Unit& unit, bool hasFma);

} // namespace sunstone::compiler
