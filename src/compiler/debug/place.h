// SPDX-License-Identifier: Apache-2.0
// The place of an address in loaded code, for messages: the source line, or without line
// information the function's name.
#pragma once

#include <string>

namespace sunstone::compiler {

// Whether the address lies in code of a pipeline or kernel. Fast.
bool isLoadedCode(const void* address);

// The function's name in its source, with the types of its parameters; other names as they are.
std::string demangled(const char* symbol);

// ", in FUNCTION, at FILE:LINE", as far as known. Functions of C++ have their names in the source.
std::string placeText(const void* address);

} // namespace sunstone::compiler
