// SPDX-License-Identifier: Apache-2.0
// Tree back to PTX text.
#pragma once

#include "ptx/ast.h"

#include <string>

namespace sunstone::ptx {

// Text that parses to the same tree. The text has no comments, pragmas, debug sections or target
// option `debug`, because the tree omits them. Scopes are flat, so names that hid one another get a
// suffix, and each register is declared separately. Functions whose addresses initialisers take are
// declared before them.
std::string print(const Module& module);

} // namespace sunstone::ptx
