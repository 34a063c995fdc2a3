// SPDX-License-Identifier: Apache-2.0
// The special registers of PTX: names and widths.
#pragma once

#include "ptx/ast.h"

#include <string_view>

namespace sunstone::ptx {

struct SpecialRegister {
    const char* name;
    Type type;
    bool vector; // has .x .y .z .w
};

// Looks up a name without a component ("%tid"); null for other names.
const SpecialRegister* findSpecialRegister(std::string_view name);

} // namespace sunstone::ptx
