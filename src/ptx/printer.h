// SPDX-License-Identifier: Apache-2.0
// Syntax tree to PTX text.
#pragma once

#include "ptx/ast.h"

#include <string>

namespace sunstone::ptx {

// Returns text that parses to the same tree. The text has no comments, pragmas, debug sections or
// target option `debug`, because the tree omits them. Scopes are flat: names that hide outer names
// get a suffix, and each register is declared separately. Functions are declared before
// initialisers that take their addresses.
std::string print(const Module& module);

} // namespace sunstone::ptx
