// SPDX-License-Identifier: Apache-2.0
// Prevents stack overflows of device programs. Trace calls and callables check the stack on each
// call (devlib), with a reserve for the functions called in between. Functions that may exceed the
// reserve get a check of their own here: recursive functions, functions called through their
// address, and functions with large frames. The check is in a small function that calls the body,
// because it must precede the entry of a large frame.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// Suffix of a checked function's body; the check takes the old name.
constexpr const char* kCheckedSuffix = ".checked";

// Call after all inlining. OptiX units only.
void addStackChecks(Unit& unit);

// Bytes of stack that `function` and all functions that it calls by name take, with each function
// of a cycle counted once. `frames` are the sizes reported by the code generator.
uint32_t stackNeed(Unit& unit, const std::string& function,
                   const std::map<std::string, uint32_t>& frames);

} // namespace sunstone::compiler
