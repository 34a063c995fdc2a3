// SPDX-License-Identifier: Apache-2.0
// BC6H and BC7: blocks of 16 bytes in one of 14 or 8 modes, with one to three pairs of end points.
#pragma once

#include <cstdint>

namespace sunstone::texture {

// Texel 0 to 15 of a block.
void decodeBc6(const uint8_t* block, unsigned texel, bool isSigned, float color[4]);
void decodeBc7(const uint8_t* block, unsigned texel, float color[4]);

} // namespace sunstone::texture
