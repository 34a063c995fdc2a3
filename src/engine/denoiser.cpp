// SPDX-License-Identifier: Apache-2.0
#include "engine/denoiser.h"

#include "base/error.h"
#include "denoise/statistics.h"

#include <cmath>
#include <cstring>

namespace sunstone::engine {
namespace {

constexpr uint64_t kStateMagic = 0x53554e44454e4f31ull;

// Work of a stream: what goes wrong in it is logged with the context and kept by the stream.
void enqueue(const std::shared_ptr<Context>& context, void* stream, std::function<void()> work) {
    enqueueLogged(context, stream, "DENOISER", std::move(work));
}

void checkState(const void* state, const denoise::Image& input) {
    DenoiserState found;
    std::memcpy(&found, state, sizeof(found));
    if (found.magic != kStateMagic)
        fail(Code::kInvalidValue, "the denoiser's state memory at ", state,
             " was overwritten since its setup");
    if (input.width > found.width || input.height > found.height)
        fail(Code::kInvalidValue, "the denoiser's state memory at ", state, " was set up for ",
             found.width, " x ", found.height, " pixels, inputs have ", input.width, " x ",
             input.height);
}

// A factor for a channel; nothing can be scaled by anything but a positive number.
float checkFactor(double factor, const char* name) {
    float value = float(factor);
    if (!(value > 1e-30f && value < 1e30f))
        fail(Code::kInvalidValue, name, " gives a factor of ", factor,
             ", which is not a positive number of usable size");
    return value;
}

void readScale(const DenoiseRequest& request, denoise::Frame& frame) {
    if (request.averageColor) {
        float averages[3];
        std::memcpy(averages, request.averageColor, sizeof(averages));
        for (int c = 0; c < 3; ++c)
            frame.scale[c] = checkFactor(0.18 / std::exp(double(averages[c])), "hdrAverageColor");
    } else if (request.intensity) {
        float intensity;
        std::memcpy(&intensity, request.intensity, sizeof(intensity));
        for (float& scale : frame.scale)
            scale = checkFactor(intensity, "hdrIntensity");
    }
}

} // namespace

void setupDenoiser(const std::shared_ptr<Context>& context, void* stream, void* state,
                   uint32_t width, uint32_t height) {
    enqueue(context, stream, [=] {
        DenoiserState value{kStateMagic, width, height};
        std::memcpy(state, &value, sizeof(value));
    });
}

void denoise(const std::shared_ptr<Context>& context, DenoiseRequest request) {
    void* stream = request.stream;
    enqueue(context, stream, [request = std::move(request)] {
        checkState(request.state, request.frame.layers.at(0).input);
        denoise::Frame frame = request.frame;
        readScale(request, frame);
        request.filter->run(frame, request.scratch);
    });
}

void computeIntensity(const std::shared_ptr<Context>& context, void* stream,
                      const denoise::Image& image, float* result) {
    enqueue(context, stream, [image, result] {
        float value = denoise::intensityScale(image);
        std::memcpy(result, &value, sizeof(value));
    });
}

void computeAverageColor(const std::shared_ptr<Context>& context, void* stream,
                         const denoise::Image& image, float* result) {
    enqueue(context, stream, [image, result] {
        float values[3];
        denoise::averageLogColor(image, values);
        std::memcpy(result, values, sizeof(values));
    });
}

} // namespace sunstone::engine
