// SPDX-License-Identifier: Apache-2.0
// What tells builds of this library apart.
#pragma once

#include <string>

namespace sunstone::compiler {

// The linker's build id of the binary that holds this code. Where the linker wrote none, a text no
// other process has, so that nothing is shared with another build by mistake.
const std::string& buildId();

} // namespace sunstone::compiler
