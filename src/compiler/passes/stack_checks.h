// SPDX-License-Identifier: Apache-2.0
// Keeps device programs from running off the end of their thread's stack. Trace calls and callables
// check on each call (devlib), with a reserve for what is called in between; what may use more than
// the reserve gets a check of its own here: recursive functions, functions called through their
// address, and functions with large frames. The check stands in a small function in front, because
// a large frame must not be entered to find out that it does not fit.
#pragma once

#include "compiler/translate/unit.h"

namespace sunstone::compiler {

// What the code of a checked function is called; its old name belongs to the check.
constexpr const char* kCheckedSuffix = ".checked";

// After all inlining. OptiX units only.
void addStackChecks(Unit& unit);

// Bytes that `function` takes with everything it calls by name, each function of a cycle once;
// frames are those that the code generator has reported.
uint32_t stackNeed(Unit& unit, const std::string& function,
                   const std::map<std::string, uint32_t>& frames);

} // namespace sunstone::compiler
