// SPDX-License-Identifier: Apache-2.0
// Identifies the build of this library.
#pragma once

#include <string>

namespace sunstone::compiler {

// The linker's build id of the binary that contains this code. Without one, a text that is unique
// to the process, so that different builds never share data.
const std::string& buildId();

} // namespace sunstone::compiler
