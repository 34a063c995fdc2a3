// SPDX-License-Identifier: Apache-2.0
// Several modules as one. Rules are those of C: global functions and variables are visible across
// modules and are defined once; internal ones belong to their module and get another name where two
// modules have the same.
#pragma once

#include "ptx/ast.h"

#include <functional>
#include <span>
#include <string>

namespace sunstone::ptx {

// Whether an internal variable is visible across modules all the same. Definitions of such
// variables, and of global ones, may stand in several modules if they are equal.
using IsShared = std::function<bool(const Module&, const Variable&)>;

// The text of the linked module. Throws Error(kInvalidValue) naming a symbol that has two
// definitions. References that no module defines stay as they are.
std::string link(std::span<const Module* const> modules, const IsShared& isShared);

} // namespace sunstone::ptx
