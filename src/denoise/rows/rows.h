// SPDX-License-Identifier: Apache-2.0
// The inner loops of the guided filter: one row of one pass, with taps in the outer loop and pixels
// in the inner one, so that compilers vectorise over pixels. Compiled once per instruction set
// (rows_*.cpp include rows_kernels.h); all give the same bits, as nothing is fused and no sum is
// reordered.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone::denoise {

constexpr int kMaxGuides = 6;

// Planes of one image, `stride` floats from row to row.
struct Planes {
    float* color[3];
    float* variance; // summed over the channels
    float* alpha;
};

struct Pass {
    uint32_t width, height;
    size_t stride;
    int guideCount;                  // 0, 2, 3, 5 or 6
    const float* guides[kMaxGuides]; // in units of their tolerance
    const float* valid;              // 1, or 0 where the input was not finite
    Planes from, to;
    // Colours for comparison: means of few pixels are more reliable than single noisy ones.
    Planes pilot;
    float* detail[3];     // the part of colours that guides explain
    float* sums[2];       // of gather
    int step;             // of an à-trous pass
    float mostReturned;   // the largest part of the structure that giveBack returns
    float colorTolerance; // squared
    bool hasAlpha;
};

struct RowKernels {
    void (*repair)(const Pass&, uint32_t y); // from.color, valid -> to.color
    // from.color -> to.variance: squared detail; pilot: mean of 3x3 and its part of the variance
    void (*residual)(const Pass&, uint32_t y);
    // from.variance -> to.variance: mean of 7x7; pilot.variance: its part becomes a variance
    void (*spread)(const Pass&, uint32_t y);
    // from.color, pilot -> detail, to.color without it; from.variance -> to.variance. With guides.
    void (*detail)(const Pass&, uint32_t y);
    void (*smooth)(const Pass&, uint32_t y); // one à-trous pass
    // The functions below restore structure: rows_return.h.
    void (*loss)(const Pass&, uint32_t y);
    void (*correlate)(const Pass&, uint32_t y);
    void (*gather)(const Pass&, uint32_t y);
    void (*sumRow)(const Pass&, uint32_t y);
    void (*meanOfBox)(const Pass&, uint32_t y);
    void (*giveBack)(const Pass&, uint32_t y);
};

constexpr int kRepairRadius = 2;
constexpr int kResidualRadius = 1;
constexpr int kSpreadRadius = 3;
constexpr int kDetailRadius = 4;
constexpr int kCorrelateRadius = 2;
constexpr int kGatherRadius = 8;
constexpr int kBoxRadius = 2;
constexpr int kBoxDistance = 3; // of boxes that do not hold the pixel, along rows and columns
static_assert(kBoxRadius + kBoxDistance <= kGatherRadius);

const RowKernels& baseRowKernels();
const RowKernels& avx2RowKernels();
// The kernels for this machine.
const RowKernels& rowKernels();

} // namespace sunstone::denoise
