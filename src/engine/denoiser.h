// SPDX-License-Identifier: Apache-2.0
// Denoising in stream order: the call copies its descriptions; images and numbers in device memory
// are read when the stream reaches it. Their errors are logged, and returned by the next denoiser
// call on the stream.
#pragma once

#include "denoise/call.h"
#include "denoise/filter.h"
#include "denoise/model.h"
#include "engine/context.h"

#include <memory>

namespace sunstone::engine {

constexpr const char* kDenoiserTag = "DENOISER"; // of the log
constexpr size_t kDenoiserStateSize = 256;
static_assert(sizeof(denoise::State) <= kDenoiserStateSize);

struct DenoiserSetup {
    void* state = nullptr;
    uint32_t width = 0, height = 0;
    void* stream = nullptr;
};

struct DenoiseRequest {
    std::shared_ptr<const denoise::Filter> filter;
    denoise::Frame frame; // `scale` is filled in from `inputs`
    denoise::CallInputs inputs = {};
    void* scratch = nullptr;
    void* stream = nullptr;
};

// One or three floats; see denoise/statistics.h.
struct StatisticsRequest {
    enum Kind { kIntensity, kAverageColor } kind;
    denoise::Image image;
    void* scratch = nullptr;
    float* result = nullptr;
    void* stream = nullptr;
};

} // namespace sunstone::engine
