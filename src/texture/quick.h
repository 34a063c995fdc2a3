// SPDX-License-Identifier: Apache-2.0
// Quick sampling: AVX2 functions for one format and filter each. Their results equal those of
// sample.cpp bit for bit (quick_test.cpp compares them). A quick function rejects calls that it
// does not cover; sample.cpp handles these.
//
// The idea: normalized positions are multiples of 2^-23, so that a position in texels is an integer
// product of the position and the size. Integers need neither a floor nor a division for the
// address modes.
#pragma once

#include "texture/device_functions.h"
#include "texture/texture.h"

namespace sunstone::texture {

// Selects the function for a complete texture; none if the processor or the texture does not
// support one.
void chooseQuick(Texture& texture);

// The functions for a format with the filter or without; null for formats of blocks.
struct QuickFunctions {
    decltype(QuickSampling::image) image = nullptr;
    decltype(QuickSampling::call) call = nullptr;
};
QuickFunctions quickFunctions(const Format& format, bool linear, bool asFloat, bool srgb);

// A sampling call without `call`, and without `image` unless `quick` is set. Tests use the generic
// code alone as their reference.
void sampleSlowly(const Texture& texture, uint32_t form, const SampleOperands& operands, bool quick,
                  uint32_t result[4]);

} // namespace sunstone::texture
