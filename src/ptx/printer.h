// SPDX-License-Identifier: Apache-2.0
// Tree back to PTX text.
#pragma once

#include "ptx/ast.h"

#include <string>

namespace sunstone::ptx {

// Text that parses to the same tree. What the tree does not hold is not in the text: comments,
// pragmas, debug sections and the target option `debug`. Scopes are flat, so that names that hid
// each other get a suffix, and each register is declared by itself. Functions whose addresses
// initialisers take are declared before them.
std::string print(const Module& module);

} // namespace sunstone::ptx
