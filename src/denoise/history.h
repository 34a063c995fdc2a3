// SPDX-License-Identifier: Apache-2.0
// Temporal blending: the previous denoised image, moved by the flow, makes the new one steadier.
// It is believed only where it fits: inside the image, within the range of the new pixel's
// neighbourhood, and no rougher than that (a noisy image in place of a first previous one).
#pragma once

#include "denoise/image.h"
#include "denoise/rows.h"

namespace sunstone::denoise {

constexpr uint32_t kHistoryRadius = 1;

struct History {
    const Image& previous;
    const Image& flow; // pixels moved since the previous image: new position minus old one
    uint32_t factor;   // pixels of the planes for one of the flow, in each direction
    float scale[3];    // brings the previous image to the range of the planes
    float weight;

    // Blends one row of `from` (colours, and the variance of their noise) with the previous image.
    void blendRow(uint32_t y, uint32_t width, uint32_t height, size_t stride, const Planes& from,
                  const Planes& to) const;
};

} // namespace sunstone::denoise
