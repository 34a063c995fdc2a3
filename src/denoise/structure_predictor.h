// SPDX-License-Identifier: Apache-2.0
// Predicts how similar a noisy image is to the one that more samples would give, for each block of
// 16 x 16 pixels: the structural similarity (structure.h) between the image and its denoised form,
// which stands for the image without noise. The output has a pixel for each block.
#pragma once

#include "denoise/guided_filter.h"

namespace sunstone::denoise {

class StructurePredictor final : public Filter {
public:
    StructurePredictor() : filter_(FilterSettings{}) {}
    uint32_t factor() const override { return 1; }
    uint32_t overlap() const override { return filter_.overlap(); }
    size_t scratchSize(uint32_t width, uint32_t height) const override;
    using Filter::run;
    void run(const Frame& frame, void* scratch, StepRunner& runner) const override;

private:
    GuidedFilter filter_;
};

} // namespace sunstone::denoise
