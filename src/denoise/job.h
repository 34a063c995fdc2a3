// SPDX-License-Identifier: Apache-2.0
// A filter as steps, independent of the device that runs them: each step is a function of one pixel
// that does not depend on its neighbours' progress, run for all pixels before the next step begins.
// The job gives a step its images and planes. Steps are written once (steps.h) and run by the
// threads of a CPU or of a GPU.
#pragma once

#include "denoise/image.h"
#include "denoise/rows/rows.h"
#include "denoise/upsampler.h"

namespace sunstone::denoise {

// In the order in which a filter with all parts runs them; see GuidedFilter::run.
enum class Step : uint32_t {
    kGuides,       // images -> guide planes
    kAlpha,        // image -> alpha plane
    kAlphaAsColor, // alpha plane -> to.color
    kColorAsAlpha, // from.color -> alpha plane
    kColor,        // image -> to.color, valid
    kRepair,       // these five: rows/rows.h
    kResidual,
    kSpread,
    kDetail,
    kSmooth,
    kLoss, // these six: rows/rows_return.h
    kCorrelate,
    kGather,
    kSumRow,
    kMeanOfBox,
    kReturn,
    kRestore,  // from: undoes the removal of detail and the division, in place
    kCompress, // these three: upsampler.h
    kTensor,
    kUpsample,
    kBlend,     // from and the previous image -> to
    kWrite,     // from -> image
    kToneMap,   // image -> image (tone_map.h)
    kStructure, // image and previous image -> image of blocks (structure.h)
    kCount,
};

enum class AlphaMode : uint8_t {
    kCopy,     // output alpha is input alpha
    kTogether, // filtered with the weights of the colours
    kSeparate, // filtered on its own
};

// Values computed when a stream reaches a call, before its first step.
struct Control {
    float scale[3];     // Frame::scale
    uint32_t isRefused; // all steps must return at once
};

// Scratch memory begins with the control, at the first place with this alignment.
constexpr size_t kScratchAlignment = 64;
static_assert(sizeof(Control) <= kScratchAlignment);
inline Control* controlIn(void* scratch) {
    const uintptr_t address = reinterpret_cast<uintptr_t>(scratch);
    return reinterpret_cast<Control*>((address + kScratchAlignment - 1) / kScratchAlignment *
                                      kScratchAlignment);
}

struct Job {
    Pass pass;
    const Control* control;
    Image input, previous, output;
    Image albedo, normal, flow;
    float* guides[kMaxGuides]; // pass.guides, to write
    float *valid, *alpha;
    Upsampler upsampler;
    uint32_t factor, outputStride; // of the planes that kBlend and kWrite read
    uint32_t offsetX, offsetY;
    float albedoTolerance, normalTolerance, historyWeight, blend;
    uint8_t normalChannels;
    bool keepsAlpha; // even if it is not finite
    bool isScaled, isLimited;
    bool isDivided;               // colours, by the albedo
    bool hasDetail;               // subtracted from colours
    float exposure, inverseGamma; // of kToneMap
};

} // namespace sunstone::denoise
