// SPDX-License-Identifier: Apache-2.0
#include "denoise/structure_predictor.h"

#include "denoise/structure.h"

namespace sunstone::denoise {

size_t StructurePredictor::scratchSize(uint32_t width, uint32_t height) const {
    return filter_.scratchSize(width, height) + kScratchAlignment +
           size_t(width) * height * pixelSizeOf(Format::kFloat3);
}

void StructurePredictor::run(const Frame& frame, void* scratch, StepRunner& runner) const {
    const Layer& layer = frame.layers.at(0);
    const uint32_t width = layer.input.width, height = layer.input.height;
    Control* const control = controlIn(scratch);
    Image denoised;
    denoised.data = static_cast<uint8_t*>(scratch) + filter_.scratchSize(width, height) +
                    kScratchAlignment - reinterpret_cast<uintptr_t>(scratch) % kScratchAlignment;
    denoised.width = width;
    denoised.height = height;
    denoised.format = Format::kFloat3;
    denoised.pixelStride = pixelSizeOf(Format::kFloat3);
    denoised.rowStride = width * denoised.pixelStride;

    Frame inner = frame;
    inner.layers = {{layer.input, {}, denoised}};
    filter_.run(inner, scratch, runner);

    Job job{};
    job.control = control;
    job.input = layer.input;
    job.previous = denoised;
    job.output = layer.output;
    job.isLimited = frame.isLimited;
    job.isScaled = true;
    runner.run(Step::kStructure, job, layer.output.width, layer.output.height);
}

} // namespace sunstone::denoise
