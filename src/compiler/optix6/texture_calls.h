// SPDX-License-Identifier: Apache-2.0
// Texture lookups by id as PTX of releases before 6 makes them: calls of `_rt_texture_get_*`, which
// take the id, the kind of lookup and all coordinates that a kind may have. Here they are functions
// in PTX that become a part of the module, so that both targets translate them as they translate
// other texture instructions. Source: OptiX 6.0 API reference, sections 8.13 and 8.18.
#pragma once

#include <string>
#include <string_view>

namespace sunstone::compiler::optix6 {

constexpr std::string_view kTextureCallPrefix = "_rt_texture_get_";

// Definitions to append to a text that has such calls; empty if it has none.
std::string textureFunctionsFor(std::string_view text);

} // namespace sunstone::compiler::optix6
