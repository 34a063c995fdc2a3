// SPDX-License-Identifier: Apache-2.0
// Denoising in stream order: descriptions are copied when a call is made, images and the numbers in
// device memory are read when the stream reaches it.
#pragma once

#include "denoise/filter.h"
#include "denoise/model.h"
#include "engine/context.h"

#include <memory>

namespace sunstone::engine {

// What setupDenoiser puts into the caller's state memory. The filters of today keep nothing else
// there; a learned model would keep its weights.
struct DenoiserState {
    uint64_t magic;
    uint32_t width, height;
};
constexpr size_t kDenoiserStateSize = 256;

struct DenoiseRequest {
    std::shared_ptr<const denoise::Filter> filter;
    denoise::Frame frame;                // `scale` is filled in from what follows
    const float* intensity = nullptr;    // device memory: one factor for all channels
    const float* averageColor = nullptr; // device memory: mean logarithm of each channel; wins
    const void* state = nullptr;
    void* scratch = nullptr;
    void* stream = nullptr;
};

void setupDenoiser(const std::shared_ptr<Context>& context, void* stream, void* state,
                   uint32_t width, uint32_t height);
void denoise(const std::shared_ptr<Context>& context, DenoiseRequest request);

// Write one and three floats; see denoise/statistics.h.
void computeIntensity(const std::shared_ptr<Context>& context, void* stream,
                      const denoise::Image& image, float* result);
void computeAverageColor(const std::shared_ptr<Context>& context, void* stream,
                         const denoise::Image& image, float* result);

} // namespace sunstone::engine
