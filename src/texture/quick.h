// SPDX-License-Identifier: Apache-2.0
// Quick sampling: functions for one format and filter each, in AVX2 code. Their results are those
// of sample.cpp bit for bit (quick_test.cpp compares them); a quick function refuses what it does
// not cover, and sample.cpp answers instead.
//
// The idea: normalized positions are multiples of 2^-23, so that a position in texels is an integer
// product of the position and the size. Integers need neither a floor nor a division for the
// address modes.
#pragma once

#include "texture/device_functions.h"
#include "texture/texture.h"

namespace sunstone::texture {

// Chooses the function for a texture that is complete; none if the processor or the texture has to
// do without.
void chooseQuick(Texture& texture);

// The functions for a format with the filter or without; null for formats of blocks.
struct QuickFunctions {
    decltype(QuickSampling::image) image = nullptr;
    decltype(QuickSampling::call) call = nullptr;
};
QuickFunctions quickFunctions(const Format& format, bool linear, bool asFloat, bool srgb);

// A sampling call without `call`, and without `image` unless `quick` says so. The generic code
// alone is the reference of tests.
void sampleSlowly(const Texture& texture, uint32_t form, const SampleOperands& operands, bool quick,
                  uint32_t result[4]);

} // namespace sunstone::texture
