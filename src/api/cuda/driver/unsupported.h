// SPDX-License-Identifier: Apache-2.0
// Functions of the driver API that exist only to say that they are not supported: programs link and
// start, and learn it where they call.
#pragma once

#include <string_view>

namespace sunstone::api::cuda {

// Whether an exported name is one of these.
bool isUnsupported(std::string_view name);

} // namespace sunstone::api::cuda
