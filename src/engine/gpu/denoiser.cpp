// SPDX-License-Identifier: Apache-2.0
// Denoising on a GPU: kernels of src/denoise/gpu in the caller's stream.
#include "engine/denoiser.h"

#include "base/error.h"
#include "engine/gpu/backend.h"

namespace sunstone::engine {

using namespace device::cuda;

denoise::gpu::GpuDenoiser& GpuBackend::denoiser() {
    std::call_once(denoiserMade_, [&] {
        denoiser_ = std::make_unique<denoise::gpu::GpuDenoiser>(driver(), &kernelCode_);
    });
    return *denoiser_;
}

// Kernels cannot return errors; the next context that calls logs them.
void GpuBackend::tellOfRefusals(const Context& context) {
    std::lock_guard lock(refusalMutex_);
    for (denoise::gpu::GpuDenoiser::Refusal& refusal : denoiser().takeRefusals()) {
        if (context.log)
            context.log(LogLevel::kError, kDenoiserTag, refusal.text);
        refusals_.emplace(refusal.stream, std::move(refusal.text));
    }
}

void GpuBackend::throwRefusal(const Context& context, CUstream stream) {
    tellOfRefusals(context);
    std::lock_guard lock(refusalMutex_);
    const auto found = refusals_.find(stream);
    if (found == refusals_.end())
        return;
    const std::string text = std::move(found->second);
    refusals_.erase(found);
    throw Error(Code::kInvalidValue, text);
}

// The driver may wait for the GPU when it loads kernels; calls that only queue work must not.
void GpuBackend::prepareDenoiser(int guidePlanes) {
    ContextScope scope(device_.context());
    denoiser().prepare(guidePlanes);
}

void GpuBackend::setupDenoiser(const ContextPtr& context, const DenoiserSetup& setup) {
    ContextScope scope(device_.context());
    const auto stream = CUstream(setup.stream);
    throwRefusal(*context, stream);
    denoiser().setUp(stream, CUdeviceptr(setup.state), setup.width, setup.height);
}

void GpuBackend::denoise(const ContextPtr& context, DenoiseRequest request) {
    ContextScope scope(device_.context());
    const auto stream = CUstream(request.stream);
    throwRefusal(*context, stream);
    denoiser().filter(stream, *request.filter, request.frame, request.scratch, request.inputs);
}

void GpuBackend::imageStatistics(const ContextPtr& context, const StatisticsRequest& request) {
    ContextScope scope(device_.context());
    const auto stream = CUstream(request.stream);
    throwRefusal(*context, stream);
    const auto run = request.kind == StatisticsRequest::kIntensity
                         ? &denoise::gpu::GpuDenoiser::intensity
                         : &denoise::gpu::GpuDenoiser::averageColor;
    (denoiser().*run)(stream, request.image, request.scratch, request.result);
}

} // namespace sunstone::engine
