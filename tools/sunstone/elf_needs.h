// SPDX-License-Identifier: Apache-2.0
// Which libraries a program names.
#pragma once

#include <string>
#include <vector>

namespace sunstone::tool {

// The DT_NEEDED entries of an ELF file of 64 bits; none of anything else. `command` is looked for
// in PATH as execvp does.
std::vector<std::string> librariesOf(const std::string& command);

} // namespace sunstone::tool
