// SPDX-License-Identifier: Apache-2.0
// The interface of a denoising filter. Its one implementation is the guided à-trous filter
// (guided_filter.h); a learned model would be a second class behind the same interface.
#pragma once

#include "denoise/image.h"
#include "denoise/job.h"

#include <vector>

namespace sunstone::denoise {

struct Layer {
    Image input;
    Image
        previous; // the layer's denoised previous frame, as large as a whole output; temporal only
    Image output; // may share memory with previous, and with input where sizes are the same
};

// One image, or one tile of an image with its surroundings.
struct Frame {
    Image albedo, normal, flow; // guides; those without data are not used
    std::vector<Layer> layers;  // inputs and guides have equal sizes
    // First pixel of the inputs that is written; outputs may cover a part of the inputs.
    uint32_t offsetX = 0, offsetY = 0;
    AlphaMode alpha = AlphaMode::kCopy;
    float blend = 0;            // 0: denoised, 1: input
    float scale[3] = {1, 1, 1}; // brings the colours of the first layer to a middle grey of 0.18
    bool isLimited = false;     // colours are 0 to 1 and perhaps not linear
    bool isTemporal = false;
    bool hasPrevious = true; // temporal: layers have previous images, except in a first frame
};

// Runs a filter's steps: on the threads of a CPU (cpu_steps.cpp), or on a GPU in stream order
// (gpu/gpu_denoiser.h).
class StepRunner {
public:
    virtual ~StepRunner() = default;
    // Called before all steps: fills `control`, which lies in the scratch memory.
    virtual void begin(Control& control) = 0;
    // Runs the step for all of width x height pixels, after all earlier steps.
    virtual void run(Step step, const Job& job, uint32_t width, uint32_t height) = 0;
};

class Filter {
public:
    virtual ~Filter() = default;
    // Pixels of the output for one of the input, in each direction: 1 or 2.
    virtual uint32_t factor() const = 0;
    // Surrounding pixels on each side with which a tile gets the bits of the whole image.
    virtual uint32_t overlap() const = 0;
    // Bytes of scratch memory for inputs of this size.
    virtual size_t scratchSize(uint32_t width, uint32_t height) const = 0;
    // Runs the steps of a frame through `runner`; touches neither the images nor `scratch` itself.
    // A layer is read completely before it is written. Results depend neither on the device nor on
    // the earlier contents of scratch.
    virtual void run(const Frame& frame, void* scratch, StepRunner& runner) const = 0;
    // On the threads of the CPU.
    void run(const Frame& frame, void* scratch) const;
};

} // namespace sunstone::denoise
