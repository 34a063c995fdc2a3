// SPDX-License-Identifier: Apache-2.0
// Texture lookups by id in PTX of releases before 6: calls of `_rt_texture_get_*`, which take the
// id, the kind of lookup and all coordinates that a kind may have. Sunstone appends these functions
// to the module as PTX, so that both targets translate them like other texture instructions.
// Source: OptiX 6.0 API reference, sections 8.13 and 8.18.
#pragma once

#include <string>
#include <string_view>

namespace sunstone::compiler::optix6 {

constexpr std::string_view kTextureCallPrefix = "_rt_texture_get_";

// The definitions to append to a text with such calls; empty for other texts.
std::string textureFunctionsFor(std::string_view text);

} // namespace sunstone::compiler::optix6
