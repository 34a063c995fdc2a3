// SPDX-License-Identifier: Apache-2.0
// Recognises input that is something else than PTX text, so that the message can name it.
#pragma once

#include <string>
#include <string_view>

namespace sunstone::ptx {

// What the bytes are and what to do about it; empty if they may be PTX.
std::string describeForeignInput(std::string_view bytes);

} // namespace sunstone::ptx
