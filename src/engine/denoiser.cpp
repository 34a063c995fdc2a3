// SPDX-License-Identifier: Apache-2.0
#include "engine/denoiser.h"

#include "base/error.h"
#include "denoise/statistics.h"
#include "engine/cpu/backend.h"

#include <algorithm>
#include <cstring>

namespace sunstone::engine::cpu {

void setupDenoiser(const ContextPtr& context, const DenoiserSetup& setup) {
    enqueueLogged(context, setup.stream, kDenoiserTag, [setup] {
        const denoise::State value{denoise::kStateMagic, setup.width, setup.height};
        std::memcpy(setup.state, &value, sizeof(value));
    });
}

void denoise(const ContextPtr& context, DenoiseRequest request) {
    void* stream = request.stream;
    enqueueLogged(context, stream, kDenoiserTag, [request = std::move(request)] {
        denoise::Control control;
        const denoise::CallFinding finding = denoise::examine(request.inputs, control);
        if (finding.fault != denoise::CallFault::kNone)
            throw Error(Code::kInvalidValue, denoise::describe(request.inputs, finding));
        denoise::Frame frame = request.frame;
        std::copy_n(control.scale, 3, frame.scale);
        request.filter->run(frame, request.scratch);
    });
}

void imageStatistics(const ContextPtr& context, const StatisticsRequest& request) {
    enqueueLogged(context, request.stream, kDenoiserTag, [request] {
        if (request.kind == StatisticsRequest::kIntensity) {
            *request.result = denoise::intensityScale(request.image);
            return;
        }
        float values[3];
        denoise::averageLogColor(request.image, values);
        std::copy_n(values, 3, request.result);
    });
}

} // namespace sunstone::engine::cpu
