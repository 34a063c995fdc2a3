// SPDX-License-Identifier: Apache-2.0
// What a denoising filter is given and what it promises. There is one today, the guided à-trous
// filter (guided_filter.h); a learned model becomes a second class behind the same interface, and
// nothing outside this folder changes.
#pragma once

#include "denoise/image.h"

#include <vector>

namespace sunstone::denoise {

enum class AlphaMode : uint8_t {
    kCopy,     // output alpha is input alpha
    kTogether, // filtered with the weights of the colours
    kSeparate, // filtered on its own
};

struct Layer {
    Image input;
    Image
        previous; // the layer's denoised previous frame, as large as a whole output; temporal only
    Image output; // may share memory with previous, and with input where sizes are the same
};

// One image, or one tile of an image with what surrounds it.
struct Frame {
    Image albedo, normal, flow; // guides; those without data are not used
    std::vector<Layer> layers;  // inputs and guides all have the same size
    // First pixel of the inputs that is written; outputs may show a part of what inputs show.
    uint32_t offsetX = 0, offsetY = 0;
    AlphaMode alpha = AlphaMode::kCopy;
    float blend = 0;            // 0: denoised, 1: input
    float scale[3] = {1, 1, 1}; // brings the colours of the first layer to a middle grey of 0.18
    bool isLimited = false;     // colours are 0 to 1 and perhaps not linear
    bool isTemporal = false;
    bool hasPrevious = true; // temporal: layers have previous images; not so in a first frame
};

class Filter {
public:
    virtual ~Filter() = default;
    // Pixels of the output for one of the input, in each direction: 1 or 2.
    virtual uint32_t factor() const = 0;
    // Pixels of surrounding that a tile needs on each side for the result to be that of the whole.
    virtual uint32_t overlap() const = 0;
    // Bytes of scratch memory for inputs of this size.
    virtual size_t scratchSize(uint32_t width, uint32_t height) const = 0;
    // Reads all of a layer before it writes it. Results depend neither on the number of threads
    // nor on what scratch held.
    virtual void run(const Frame& frame, void* scratch) const = 0;
};

} // namespace sunstone::denoise
