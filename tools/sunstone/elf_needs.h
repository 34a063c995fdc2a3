// SPDX-License-Identifier: Apache-2.0
// The libraries that a program needs.
#pragma once

#include <string>
#include <vector>

namespace sunstone::tool {

// The DT_NEEDED entries of a 64-bit ELF file; empty for other files. Searches PATH for `command`,
// as execvp does.
std::vector<std::string> librariesOf(const std::string& command);

} // namespace sunstone::tool
