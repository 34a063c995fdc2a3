// SPDX-License-Identifier: Apache-2.0
// Texels to numbers and back: the formats of array.h.
#pragma once

#include "texture/array.h"

namespace sunstone::texture {

// The way in which a texture reads its texels.
struct Reading {
    bool asFloat = false; // integers become numbers in [0, 1] or [-1, 1]
    bool srgb = false;
    bool unclamped = false; // for filters: the least signed fraction remains below -1
};

// The four channels at (x, y) of a slice as words: floats, or integers where the format holds
// integers and `asFloat` is not set. Channels that the format lacks are 0. x and y are inside the
// image.
void fetchTexel(const Format& format, Reading reading, const uint8_t* slice, size_t rowPitch,
                uint32_t x, uint32_t y, uint32_t words[4]);

// The value read for a border of this colour: stored in the format and read back.
void borderTexel(const Format& format, Reading reading, const float color[4], uint32_t words[4]);

// Stores words in the texel's format as GPUs do: integers saturate, floats are truncated to halves.
void storeWords(const Format& format, uint8_t* texel, const uint32_t words[4]);

// One texel of a 4 x 4 block; block formats only.
void decodeBlock(Channel channel, const uint8_t* block, unsigned x, unsigned y, float color[4]);

// The numbers of the 256 values of an sRGB channel.
const float* srgbNumbers();

float halfToFloat(uint16_t half);
uint16_t floatToHalf(float value);

} // namespace sunstone::texture
