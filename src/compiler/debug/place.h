// SPDX-License-Identifier: Apache-2.0
// The place of an address in loaded code, for messages: the source line, or without line
// information the function's name.
#pragma once

#include <string>

namespace sunstone::compiler {

// Whether the address lies in code of a pipeline or kernel. Fast.
bool isLoadedCode(const void* address);

// ", in FUNCTION, at FILE:LINE", as far as known.
std::string placeText(const void* address);

} // namespace sunstone::compiler
