// SPDX-License-Identifier: Apache-2.0
// OptiX 7 programs have their kind in their name. Source: OptiX Programming Guide 7.4, "Programs".
#pragma once

#include "compiler/compiler.h"

#include <string_view>

namespace sunstone::compiler {

ProgramKind programKind(std::string_view functionName); // by prefix "__raygen__" ...; kNone: none
const char* prefixOf(ProgramKind kind);

} // namespace sunstone::compiler
