// SPDX-License-Identifier: Apache-2.0
// The filters of stages, as requests to the engine.
#include "api/optix6/context.h"
#include "api/optix6/post/stage.h"
#include "denoise/structure.h"
#include "denoise/structure_predictor.h"
#include "denoise/tone_mapper.h"

#include <algorithm>
#include <limits>

namespace sunstone::optix6 {

namespace {

constexpr uint32_t kLeastTile = 16;

// Input pixels that a tile of the output needs in one direction.
uint32_t withOverlap(uint32_t tile, uint32_t whole, uint32_t overlap) {
    return uint32_t(std::min<uint64_t>(whole, uint64_t(tile) + 2 * uint64_t(overlap)));
}

denoise::Image partOf(const denoise::Image& whole, uint32_t x, uint32_t y, uint32_t width,
                      uint32_t height) {
    denoise::Image part = whole;
    if (part)
        part.data = whole.pixel(x, y);
    part.width = width;
    part.height = height;
    return part;
}

} // namespace

void PostProcessingStage::reserve(size_t scratchBytes) {
    const std::shared_ptr<engine::Backend>& backend = context()->engine->backend;
    if (!small_.get())
        small_ = SharedMemory(backend, sizeof(Small));
    if (scratch_.size() < scratchBytes) {
        scratch_ = {}; // first, because there may not be room for both
        scratch_ = SharedMemory(backend, scratchBytes);
    }
}

// Uses memory that reserve() has allocated.
void PostProcessingStage::submit(const std::shared_ptr<const denoise::Filter>& filter,
                                 const denoise::Frame& frame) {
    const engine::ContextPtr& engine = context()->engine;
    engine::DenoiseRequest request;
    request.filter = filter;
    request.frame = frame;
    request.inputs.state = small().state;
    request.inputs.intensity = isMeasured_ ? &small().intensity : nullptr;
    request.inputs.width = frame.layers[0].input.width;
    request.inputs.height = frame.layers[0].input.height;
    request.scratch = scratch_.get();
    engine->backend->setupDenoiser(engine,
                                   {small().state, request.inputs.width, request.inputs.height});
    engine->backend->denoise(engine, std::move(request));
}

void PostProcessingStage::mapTones(const Images& images) {
    constexpr double kMost = 1e30;
    const double exposure = number("exposure", 1.0, 0.0, kMost);
    const double gamma = number("gamma", 2.2, 1e-3, 1e3);
    const auto filter = std::make_shared<denoise::ToneMapper>(float(exposure), float(gamma));
    denoise::Frame frame;
    frame.layers.push_back({images.input, {}, images.output});
    reserve(filter->scratchSize(images.input.width, images.input.height));
    isMeasured_ = false;
    submit(filter, frame);
}

denoise::Frame PostProcessingStage::frameOf(const Images& images) {
    noteTrainingData();
    context()->engine->backend->prepareDenoiser((images.albedo ? 3 : 0) + (images.normal ? 2 : 0));
    denoise::Frame frame;
    frame.albedo = images.albedo;
    frame.normal = images.normal;
    frame.isLimited = number("hdr", 0.0, std::numeric_limits<int>::min(),
                             std::numeric_limits<unsigned>::max()) == 0.0;
    frame.layers.push_back({images.input, {}, images.output});
    return frame;
}

// Measures the brightness of the whole image, for filters of colours without a limit.
void PostProcessingStage::measure(const denoise::Image& image) {
    const engine::ContextPtr& engine = context()->engine;
    engine->backend->imageStatistics(engine, {engine::StatisticsRequest::kIntensity, image,
                                              scratch_.get(), &small().intensity, nullptr});
    engine->device->synchronize(nullptr);
    // Limits the factor of images that are nearly black, or brighter than filters can scale.
    small().intensity = std::clamp(small().intensity, 1e-20f, 1e20f);
    isMeasured_ = true;
}

void PostProcessingStage::predictStructure(const Images& images) {
    const auto filter = std::make_shared<denoise::StructurePredictor>();
    const denoise::Frame frame = frameOf(images);
    reserve(filter->scratchSize(images.input.width, images.input.height));
    isMeasured_ = false;
    if (!frame.isLimited)
        measure(images.input);
    submit(filter, frame);
}

void PostProcessingStage::denoise(const Images& images) {
    const auto filter = std::make_shared<denoise::GuidedFilter>(denoise::FilterSettings{});
    denoise::Frame frame = frameOf(images);
    frame.blend = float(number("blend", 0.0, 0.0, 1.0));
    constexpr double kMostBytes = 0x1p62;
    const double limit = number("maxmem", 0.0, 0.0, kMostBytes);
    number("overlap", 0.0, 0.0, kMostBytes); // tiles have the surroundings that the filter needs
    const uint32_t width = images.input.width, height = images.input.height;
    uint32_t tileWidth = width, tileHeight = height;
    const auto bytes = [&] {
        return filter->scratchSize(withOverlap(tileWidth, width, filter->overlap()),
                                   withOverlap(tileHeight, height, filter->overlap()));
    };
    while (limit > 0.0 && double(bytes()) > limit) {
        uint32_t& longer = tileWidth > tileHeight ? tileWidth : tileHeight;
        if (longer <= kLeastTile)
            refuseIt(RT_ERROR_MEMORY_ALLOCATION_FAILED, "maxmem", "= ", limit,
                     " bytes, but the smallest tile needs ", bytes());
        longer = (longer + 1) / 2;
    }
    reserve(bytes());
    isMeasured_ = false;
    if (!frame.isLimited)
        measure(images.input);
    if (tileWidth == width && tileHeight == height)
        submit(filter, frame);
    else
        submitTiles(filter, frame, tileWidth, tileHeight);
}

// Filters in tiles. The tiles have the bits of the whole image.
void PostProcessingStage::submitTiles(const std::shared_ptr<const denoise::Filter>& filter,
                                      const denoise::Frame& whole, uint32_t tileWidth,
                                      uint32_t tileHeight) {
    const denoise::Image input = whole.layers[0].input;
    denoise::Image output = whole.layers[0].output;
    const std::shared_ptr<engine::Backend>& backend = context()->engine->backend;
    const size_t bytes = output.rowStride * output.height;
    uint8_t* const place = output.data;
    // In place, a tile would read pixels that its neighbours have written.
    const bool isRead =
        place == input.data || place == whole.albedo.data || place == whole.normal.data;
    if (isRead) {
        if (copy_.size() < bytes)
            copy_ = SharedMemory(backend, bytes);
        output.data = static_cast<uint8_t*>(copy_.get());
    }
    const uint32_t overlap = filter->overlap();
    for (uint32_t y = 0; y < input.height; y += tileHeight)
        for (uint32_t x = 0; x < input.width; x += tileWidth) {
            const uint32_t left = x - std::min(x, overlap), top = y - std::min(y, overlap);
            const uint32_t tileRight = std::min(input.width, x + tileWidth);
            const uint32_t tileBottom = std::min(input.height, y + tileHeight);
            const uint32_t width = std::min(input.width, tileRight + overlap) - left;
            const uint32_t height = std::min(input.height, tileBottom + overlap) - top;
            denoise::Frame tile = whole;
            tile.albedo = partOf(whole.albedo, left, top, width, height);
            tile.normal = partOf(whole.normal, left, top, width, height);
            tile.offsetX = x - left;
            tile.offsetY = y - top;
            tile.layers[0].input = partOf(input, left, top, width, height);
            tile.layers[0].output = partOf(output, x, y, tileRight - x, tileBottom - y);
            submit(filter, tile);
        }
    if (!isRead)
        return;
    context()->engine->device->synchronize(nullptr);
    backend->copy(place, output.data, bytes);
}

} // namespace sunstone::optix6
