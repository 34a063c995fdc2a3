// SPDX-License-Identifier: Apache-2.0
// Inputs of a call in device memory other than its images, and their errors: checked when the
// stream reaches the call, by the host or by a GPU.
#pragma once

#include "denoise/job.h"
#include "denoise/logarithm.h"

#include <string>

namespace sunstone::denoise {

// The caller's state memory. The filter stores only this; a learned model would add its weights.
struct State {
    uint64_t magic;
    uint32_t width, height; // that it was set up for
};
constexpr uint64_t kStateMagic = 0x53554e44454e4f31ull;

struct CallInputs {
    const void* state;
    const float* intensity;    // one factor for all channels; may be null
    const float* averageColor; // mean logarithm of each channel; may be null, else used instead
    uint32_t width, height;    // of the inputs
};

enum class CallFault : uint32_t { kNone, kOverwritten, kTooSmall, kAverageColor, kIntensity };

struct CallFinding {
    CallFault fault;
    State state;
    double factor; // the unusable one
};

// The message of the error.
std::string describe(const CallInputs& inputs, const CallFinding& finding);

// Fills `control`.
inline CallFinding examine(const CallInputs& inputs, Control& control) {
    CallFinding finding = {};
    __builtin_memcpy(&finding.state, inputs.state, sizeof(State));
    control.isRefused = 1;
    for (float& scale : control.scale)
        scale = 1.0f;
    if (finding.state.magic != kStateMagic) {
        finding.fault = CallFault::kOverwritten;
        return finding;
    }
    if (inputs.width > finding.state.width || inputs.height > finding.state.height) {
        finding.fault = CallFault::kTooSmall;
        return finding;
    }
    for (int c = 0; c < 3 && (inputs.averageColor || inputs.intensity); ++c) {
        finding.factor = inputs.averageColor ? 0.18 / exponential(double(inputs.averageColor[c]))
                                             : double(*inputs.intensity);
        const float factor = float(finding.factor);
        // A scale must be a positive number.
        if (!(factor > 1e-30f && factor < 1e30f)) {
            finding.fault = inputs.averageColor ? CallFault::kAverageColor : CallFault::kIntensity;
            return finding;
        }
        control.scale[c] = factor;
    }
    control.isRefused = 0;
    return finding;
}

} // namespace sunstone::denoise
