// SPDX-License-Identifier: Apache-2.0
#include "denoise/tone_mapper.h"

namespace sunstone::denoise {

size_t ToneMapper::scratchSize(uint32_t, uint32_t) const {
    return 2 * kScratchAlignment;
}

void ToneMapper::run(const Frame& frame, void* scratch, StepRunner& runner) const {
    Control* const control = controlIn(scratch);
    runner.begin(*control);
    Job job{};
    job.control = control;
    job.exposure = exposure_;
    job.inverseGamma = inverseGamma_;
    for (const Layer& layer : frame.layers) {
        job.input = layer.input;
        job.output = layer.output;
        runner.run(Step::kToneMap, job, layer.output.width, layer.output.height);
    }
}

} // namespace sunstone::denoise
