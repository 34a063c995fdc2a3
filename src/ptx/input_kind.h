// SPDX-License-Identifier: Apache-2.0
// Recognises input that is not PTX text, so that the message can name its format.
#pragma once

#include <string>
#include <string_view>

namespace sunstone::ptx {

// The input's format and a remedy; empty if the bytes may be PTX.
std::string describeForeignInput(std::string_view bytes);

} // namespace sunstone::ptx
