// SPDX-License-Identifier: Apache-2.0
// Maps the colours of an image to those of a screen, pixel by pixel: c -> min(exposure c,
// 1)^(1/gamma). Alpha is copied.
#pragma once

#include "denoise/filter.h"

namespace sunstone::denoise {

class ToneMapper final : public Filter {
public:
    // Both are finite; exposure is at least 0, gamma above 0.
    ToneMapper(float exposure, float gamma) : exposure_(exposure), inverseGamma_(1.0f / gamma) {}
    uint32_t factor() const override { return 1; }
    uint32_t overlap() const override { return 0; }
    size_t scratchSize(uint32_t width, uint32_t height) const override;
    using Filter::run;
    void run(const Frame& frame, void* scratch, StepRunner& runner) const override;

private:
    float exposure_, inverseGamma_;
};

} // namespace sunstone::denoise
