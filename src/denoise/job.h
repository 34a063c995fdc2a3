// SPDX-License-Identifier: Apache-2.0
// What a filter is made of for whatever runs it: steps, each of them a function of one pixel that
// knows nothing of its neighbours' progress, run for all pixels before the next step begins; and
// the job that tells a step where its images and planes are. Steps are written once (steps.h) and
// run by the threads of a CPU or those of a GPU.
#pragma once

#include "denoise/image.h"
#include "denoise/rows.h"
#include "denoise/upsampler.h"

namespace sunstone::denoise {

// In the order in which a filter of all parts runs them; see GuidedFilter::run.
enum class Step : uint32_t {
    kGuides,       // images -> guide planes
    kAlpha,        // image -> alpha plane
    kAlphaAsColor, // alpha plane -> to.color
    kColorAsAlpha, // from.color -> alpha plane
    kColor,        // image -> to.color, valid
    kRepair,       // these five: rows.h
    kResidual,
    kSpread,
    kDetail,
    kSmooth,
    kRestore,  // from: what was taken out of the colours or divided off comes back, in place
    kCompress, // these three: upsampler.h
    kTensor,
    kUpsample,
    kBlend, // from and the previous image -> to
    kWrite, // from -> image
    kCount,
};

enum class AlphaMode : uint8_t {
    kCopy,     // output alpha is input alpha
    kTogether, // filtered with the weights of the colours
    kSeparate, // filtered on its own
};

// What is found out when a stream reaches a call, before its first step.
struct Control {
    float scale[3];     // Frame::scale
    uint32_t isRefused; // no step may do anything
};

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
    bool keepsAlpha; // whatever it is
    bool isScaled, isLimited;
    bool isDivided; // colours, by the albedo
    bool hasDetail; // taken out of colours
};

} // namespace sunstone::denoise
