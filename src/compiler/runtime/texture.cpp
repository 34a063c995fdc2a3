// SPDX-License-Identifier: Apache-2.0
// The sampler's functions under the names used by compiled code.
#include "compiler/runtime/runtime.h"

#include "texture/device_functions.h"

#include <iterator>

namespace sunstone::compiler {

void addTextureSymbols(std::vector<RuntimeSymbol>& symbols) {
    const RuntimeSymbol own[] = {
        {"sunstone_texture", reinterpret_cast<const void*>(texture::sample)},
        {"sunstone_texture_memory", reinterpret_cast<const void*>(texture::linearMemory)},
        {"sunstone_footprint", reinterpret_cast<const void*>(texture::footprint)},
        {"sunstone_texture_query", reinterpret_cast<const void*>(texture::queryTexture)},
        {"sunstone_surface", reinterpret_cast<const void*>(texture::surfaceAddress)},
        {"sunstone_surface_query", reinterpret_cast<const void*>(texture::querySurface)},
        {"sunstone_surface_load", reinterpret_cast<const void*>(texture::loadTexel)},
        {"sunstone_surface_store", reinterpret_cast<const void*>(texture::storeTexel)},
        {"sunstone_surface_reduce", reinterpret_cast<const void*>(texture::reduceTexel)},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

} // namespace sunstone::compiler
