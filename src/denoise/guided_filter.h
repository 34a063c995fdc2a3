// SPDX-License-Identifier: Apache-2.0
// The guided à-trous filter. Idea: pixels of path-traced images are independent noisy estimates;
// average each with neighbours that belong to the same surface (guides) and whose colours differ by
// no more than the noise explains.
//
//   1. Colours are divided by the albedo guide, which separates textures from noise, and multiplied
//      by it at the end. In limited range they are squared instead, which roughly undoes the
//      encoding for a screen.
//   2. Values that are not finite, and fireflies, are replaced or cut by statistics of 5x5 pixels.
//   3. The noise's variance is estimated from the residual of a 3x3 mean, averaged over 7x7 pixels.
//   4. The part of a pixel's difference from its surroundings that a local regression on the guides
//      explains is taken out, and added back at the end (rows/rows_detail.h).
//   5. Passes of a 5x5 B-spline with steps 1, 2, 4... (Dammertz et al. 2010, Schied et al. 2017).
//      A neighbour's weight falls with the distance of its guides and with the part of its colour
//      difference that the variance of both does not explain; the variance is carried along.
//   6. Where the difference to the given colours is no noise, it returns (rows/rows_return.h).
//   7. Temporal: the previous image, moved by the flow, is blended in as far as it is in the range
//      of the new one.
//
// Everything is local: a pixel depends on inputs within overlap() of it, computed in the same order
// wherever it lies in memory, so that tiles give the bits of the whole image. Read next: job.h for
// the steps, rows/rows.h for the inner loops.
#pragma once

#include "denoise/filter.h"

namespace sunstone::denoise {

// The tunable settings; a user model contains one set.
struct FilterSettings {
    uint32_t passes = 4;         // 1 to kMaxPasses
    float colorTolerance = 2.0f; // in standard deviations of the noise
    float albedoTolerance = 0.2f;
    float normalTolerance = 0.3f;
    float historyWeight = 0.8f; // temporal: part of the previous image, 0 to below 1
};
constexpr uint32_t kMaxPasses = 5;

class GuidedFilter final : public Filter {
public:
    // Factor 2: upsampled before temporal blending, see upsampler.h.
    explicit GuidedFilter(const FilterSettings& settings, uint32_t factor = 1)
        : settings_(settings), factor_(factor) {}
    uint32_t factor() const override { return factor_; }
    uint32_t overlap() const override;
    size_t scratchSize(uint32_t width, uint32_t height) const override;
    using Filter::run;
    void run(const Frame& frame, void* scratch, StepRunner& runner) const override;

private:
    FilterSettings settings_;
    uint32_t factor_;
};

} // namespace sunstone::denoise
