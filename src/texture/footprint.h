// SPDX-License-Identifier: Apache-2.0
// Which texels a sampling call reads: the sampler runs as always, but notes texels instead of
// reading them (TexelRecord). footprint.cpp packs the note into the form of the device API.
#pragma once

#include "texture/device_functions.h"
#include "texture/texture.h"

namespace sunstone::texture {

// Four texels of each of 16 probes on two levels, and room to spare.
struct TexelRecord {
    static constexpr unsigned kMost = 256;
    struct Texel {
        const Image* image;
        uint32_t x, y;
    };
    Texel texels[kMost];
    unsigned count = 0;

    void add(const Image& image, uint32_t x, uint32_t y) {
        if (count < kMost)
            texels[count++] = {&image, x, y};
    }
};

// As sample(), but for the record. False if the handle is no texture of images.
bool recordTexels(uint64_t handle, uint32_t form, const SampleOperands& operands,
                  TexelRecord& record);

} // namespace sunstone::texture
