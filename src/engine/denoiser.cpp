// SPDX-License-Identifier: Apache-2.0
#include "engine/denoiser.h"

#include "base/error.h"
#include "denoise/statistics.h"

#include <cmath>
#include <cstdlib>
#include <cstring>

namespace sunstone::engine {
namespace {

constexpr uint64_t kStateMagic = 0x53554e44454e4f31ull;

// What happens on the host; see Backend::runOnHost.
constexpr const char* kTag = "DENOISER";

HostRegion bytesAt(const void* address, size_t size, bool isWritten = false) {
    return {const_cast<void*>(address), size, 1, size, isWritten};
}

HostRegion rowsOf(const denoise::Image& image, bool isWritten = false) {
    return {image.data, image.width * image.pixelStride, image.height, image.rowStride, isWritten};
}

denoise::Image at(denoise::Image image, const HostRegion& region) {
    image.data = region.host;
    image.rowStride = region.hostStride;
    return image;
}

// Calls `visit` with each image there is, and whether it is an output; always in the same order.
template <class Visit>
void forEachImage(denoise::Frame& frame, const Visit& visit) {
    const auto offer = [&](denoise::Image& image, bool isOutput) {
        if (image)
            visit(image, isOutput);
    };
    offer(frame.albedo, false);
    offer(frame.normal, false);
    offer(frame.flow, false);
    for (denoise::Layer& layer : frame.layers) {
        offer(layer.input, false);
        offer(layer.previous, false);
        offer(layer.output, true);
    }
}

void checkState(const void* held, const void* state, const denoise::Image& input) {
    DenoiserState found;
    std::memcpy(&found, held, sizeof(found));
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

void readScale(const DenoiseRequest& request, const void* held, denoise::Frame& frame) {
    if (request.averageColor) {
        float averages[3];
        std::memcpy(averages, held, sizeof(averages));
        for (int c = 0; c < 3; ++c)
            frame.scale[c] = checkFactor(0.18 / std::exp(double(averages[c])), "hdrAverageColor");
    } else if (request.intensity) {
        float intensity;
        std::memcpy(&intensity, held, sizeof(intensity));
        for (float& scale : frame.scale)
            scale = checkFactor(intensity, "hdrIntensity");
    }
}

// The caller's scratch memory, or where the host cannot reach it some of the host's.
class Scratch {
public:
    Scratch(void* given, bool isShared, size_t size) : memory_(given) {
        constexpr size_t kAlignment = 256;
        if (isShared)
            return;
        own_.reset(std::aligned_alloc(kAlignment, (size / kAlignment + 1) * kAlignment));
        if (!own_)
            fail(Code::kOutOfMemory, "no ", size, " bytes of host memory for the denoiser");
        memory_ = own_.get();
    }
    void* memory() const { return memory_; }

private:
    struct Free {
        void operator()(void* memory) const { std::free(memory); }
    };
    void* memory_;
    std::unique_ptr<void, Free> own_;
};

} // namespace

void setupDenoiser(const std::shared_ptr<Context>& context, void* stream, void* state,
                   uint32_t width, uint32_t height) {
    if (!context->backend->sharesMemory() && context->log)
        context->log(LogLevel::kInfo, kTag,
                     "images are copied to the host, where the filter runs, and back");
    context->backend->runOnHost(context, stream, kTag,
                                {{bytesAt(state, sizeof(DenoiserState), true)},
                                 [=](const std::vector<HostRegion>& regions) {
                                     const DenoiserState value{kStateMagic, width, height};
                                     std::memcpy(regions[0].host, &value, sizeof(value));
                                 }});
}

void denoise(const std::shared_ptr<Context>& context, DenoiseRequest request) {
    HostWork work;
    work.regions.push_back(bytesAt(request.state, sizeof(DenoiserState)));
    if (request.averageColor)
        work.regions.push_back(bytesAt(request.averageColor, 3 * sizeof(float)));
    else if (request.intensity)
        work.regions.push_back(bytesAt(request.intensity, sizeof(float)));
    forEachImage(request.frame, [&](const denoise::Image& image, bool isOutput) {
        work.regions.push_back(rowsOf(image, isOutput));
    });
    const bool isShared = context->backend->sharesMemory();
    void* stream = request.stream;
    work.run = [request = std::move(request), isShared](const std::vector<HostRegion>& regions) {
        size_t next = 0;
        checkState(regions[next++].host, request.state, request.frame.layers.at(0).input);
        denoise::Frame frame = request.frame;
        if (request.averageColor || request.intensity)
            readScale(request, regions[next++].host, frame);
        forEachImage(frame,
                     [&](denoise::Image& image, bool) { image = at(image, regions[next++]); });
        const denoise::Image& input = frame.layers[0].input;
        const Scratch scratch(request.scratch, isShared,
                              request.filter->scratchSize(input.width, input.height));
        request.filter->run(frame, scratch.memory());
    };
    context->backend->runOnHost(context, stream, kTag, std::move(work));
}

void computeIntensity(const std::shared_ptr<Context>& context, void* stream,
                      const denoise::Image& image, float* result) {
    context->backend->runOnHost(context, stream, kTag,
                                {{rowsOf(image), bytesAt(result, sizeof(float), true)},
                                 [image](const std::vector<HostRegion>& regions) {
                                     const float value =
                                         denoise::intensityScale(at(image, regions[0]));
                                     std::memcpy(regions[1].host, &value, sizeof(value));
                                 }});
}

void computeAverageColor(const std::shared_ptr<Context>& context, void* stream,
                         const denoise::Image& image, float* result) {
    context->backend->runOnHost(context, stream, kTag,
                                {{rowsOf(image), bytesAt(result, 3 * sizeof(float), true)},
                                 [image](const std::vector<HostRegion>& regions) {
                                     float values[3];
                                     denoise::averageLogColor(at(image, regions[0]), values);
                                     std::memcpy(regions[1].host, values, sizeof(values));
                                 }});
}

} // namespace sunstone::engine
