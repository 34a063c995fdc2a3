// SPDX-License-Identifier: Apache-2.0
// Links several modules into one by the rules of C: global functions and variables are visible
// across modules and are defined once. Internal symbols belong to their module and get another name
// if two modules have the same name.
#pragma once

#include "ptx/ast.h"

#include <functional>
#include <span>
#include <string>

namespace sunstone::ptx {

// Whether an internal variable is nevertheless visible across modules. Several modules may define
// such variables, and global ones, if the definitions are equal.
using IsShared = std::function<bool(const Module&, const Variable&)>;

// The text of the linked module. Throws Error(kInvalidValue) naming a symbol that has two
// definitions. References without a definition remain unchanged.
std::string link(std::span<const Module* const> modules, const IsShared& isShared);

} // namespace sunstone::ptx
