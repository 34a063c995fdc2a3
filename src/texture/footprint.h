// SPDX-License-Identifier: Apache-2.0
// The texels that a sampling call reads: the sampler runs as usual but records texels (TexelRecord)
// instead of reading them. footprint.cpp packs the record into the form of the device API.
#pragma once

#include "texture/device_functions.h"
#include "texture/texture.h"

namespace sunstone::texture {

// Four texels of each of 16 probes on two levels, plus a reserve.
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

// Like sample(), but fills the record. False if the handle is not a texture of images.
bool recordTexels(uint64_t handle, uint32_t form, const SampleOperands& operands,
                  TexelRecord& record);

} // namespace sunstone::texture
