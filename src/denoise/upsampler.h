// SPDX-License-Identifier: Apache-2.0
// Makes a denoised image twice as wide and high. There is nothing finer to be guided by: all images
// have the size of the input. What they show is where edges are and which way they run.
//
//   1. Colours are compressed (fourth roots), so that a lamp does not outshine what is beside it.
//   2. The structure tensor of colours and guides tells direction and strength of edges.
//   3. A pixel's four successors are interpolated by a cubic without overshoot where there is no
//      edge, and by a Gaussian kernel that is stretched along the edge where there is one (steering
//      kernels: Takeda, Farsiu, Milanfar 2007): it takes the steps and the noise out of edges.
//
// A pixel depends on inputs within kUpsamplerRadius.
#pragma once

#include "denoise/rows.h"

namespace sunstone::denoise {

constexpr uint32_t kUpsamplerRadius = 2;

struct Upsampler {
    uint32_t width, height; // of the input
    size_t stride;          // of the input's planes, in floats
    int guideCount;
    const float* const* guides; // in units of their tolerance
    const float* const* color;
    const float* variance;
    float* compressed[3]; // scratch, planes like the input's
    float* tensor[3];     // likewise
    size_t outputStride;
    Planes to; // colours and variance of twice the width and height

    // Each of them for all rows, one after the other.
    void compressRow(uint32_t y) const;
    void tensorRow(uint32_t y) const;
    void upsampleRow(uint32_t y) const; // two rows of the output
};

} // namespace sunstone::denoise
