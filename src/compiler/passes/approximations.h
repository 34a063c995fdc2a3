// SPDX-License-Identifier: Apache-2.0
// sin, cos, ex2, lg2 and tanh of single precision as code that the optimiser can inline. Errors are
// far below the limits of the PTX manual for the .approx forms; approximations_test.cpp has them.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// Marks functions that may run in either mode of flush.h: only .ftz forms, which flush explicitly.
constexpr const char* kAnyModeAttribute = "sunstone-any-mode";

// The function for an opcode. ftz: operands are never subnormal, nor are results.
llvm::Function* approximation(Unit& unit, std::string_view opcode, bool ftz);

} // namespace sunstone::compiler
