// SPDX-License-Identifier: Apache-2.0
// Fuzzing of the denoiser: kinds, sizes, images of all formats, tiles, statistics, user models.
#include "world.h"

namespace fuzz {
namespace {

constexpr unsigned kMostPixels = 48; // in each direction

OptixImage2D image(World& w, unsigned width, unsigned height, bool isFlow = false) {
    OptixImage2D i{};
    i.format = isFlow == w.chance(97)
                   ? w.enumerator({OPTIX_PIXEL_FORMAT_FLOAT2, OPTIX_PIXEL_FORMAT_HALF2})
                   : w.enumerator({OPTIX_PIXEL_FORMAT_FLOAT4, OPTIX_PIXEL_FORMAT_FLOAT3,
                                   OPTIX_PIXEL_FORMAT_HALF4, OPTIX_PIXEL_FORMAT_HALF3,
                                   OPTIX_PIXEL_FORMAT_UCHAR4, OPTIX_PIXEL_FORMAT_UCHAR3});
    i.width = w.nearly(width);
    i.height = w.nearly(height);
    i.rowStrideInBytes = w.chance(95) ? 16 * width : w.any32();
    i.pixelStrideInBytes = w.chance(90) ? 0 : w.oneOf({16u, 12u, 8u, 6u, 3u, w.any32()});
    size_t size = size_t(16) * width * height;
    i.data = w.address(size, 16);
    if (w.chance(40)) {
        CUdeviceptr at = w.memory(size, 16);
        for (size_t k = 0; k < size / 4; k += 1 + w.below(7))
            reinterpret_cast<float*>(at)[k] = w.anyFloat();
        i.data = at;
    }
    return i;
}

void create(World& w) {
    if (w.denoisers.live.size() > 3)
        return;
    OptixDenoiserOptions options{w.chance(90) ? w.below(2) : w.any32(),
                                 w.chance(90) ? w.below(2) : w.any32()};
    auto kind = w.enumerator({
        OPTIX_DENOISER_MODEL_KIND_LDR, OPTIX_DENOISER_MODEL_KIND_HDR, OPTIX_DENOISER_MODEL_KIND_AOV,
            OPTIX_DENOISER_MODEL_KIND_TEMPORAL,
#if FUZZ_76
            OPTIX_DENOISER_MODEL_KIND_UPSCALE2X,
#endif
            OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV
    });
    OptixDenoiser denoiser = nullptr;
    OptixResult result = optixDenoiserCreate(w.context(), kind, w.chance(97) ? &options : nullptr,
                                             w.chance(97) ? &denoiser : nullptr);
    if (result == OPTIX_SUCCESS)
        w.denoisers.live.push_back(denoiser);
    w.done("optixDenoiserCreate", result);
}
const Call kCreate{"optixDenoiserCreate", 3, create};

void createWithModel(World& w) {
    uint8_t model[64];
    for (uint8_t& byte : model)
        byte = uint8_t(w.any32());
    if (w.chance(70))
        std::memcpy(model, "SUNDENOI\1\0\0\0\70\0\0\0\1\0\0\0\1\0\0\0", 24);
    if (w.chance(70)) { // kind, guides, passes, three tolerances, weight of the history
        const uint32_t numbers[3] = {w.below(6), w.below(5), w.below(8)};
        const float floats[4] = {w.anyFloat(), 0.5f, 1.0f, w.chance(80) ? 0.7f : w.anyFloat()};
        std::memcpy(model + 24, numbers, sizeof(numbers));
        std::memcpy(model + 36, floats, sizeof(floats));
        uint32_t sum = 2166136261u; // the checksum that belongs to it
        for (unsigned i = 0; i < 52; ++i)
            sum = (sum ^ model[i]) * 16777619u;
        std::memcpy(model + 52, &sum, sizeof(sum));
    }
    OptixDenoiser denoiser = nullptr;
    OptixResult result = optixDenoiserCreateWithUserModel(
        w.context(), w.chance(95) ? model : nullptr, w.chance(80) ? 56 : w.below(65),
        w.chance(97) ? &denoiser : nullptr);
    if (result == OPTIX_SUCCESS)
        w.denoisers.live.push_back(denoiser);
    w.done("optixDenoiserCreateWithUserModel", result);
}
const Call kCreateWithModel{"optixDenoiserCreateWithUserModel", 1, createWithModel};

void destroy(World& w) {
    OptixDenoiser denoiser = w.pick(w.denoisers);
    OptixResult result = optixDenoiserDestroy(denoiser);
    if (result == OPTIX_SUCCESS)
        w.denoisers.died(denoiser);
    w.done("optixDenoiserDestroy", result);
}
const Call kDestroy{"optixDenoiserDestroy", 1, destroy};

// Queries the sizes, sets up and denoises one image.
void denoise(World& w) {
    if (w.mapped() > (size_t(64) << 20) || (w.denoisers.live.empty() && w.chance(90)))
        return;
    OptixDenoiser denoiser = w.pick(w.denoisers);
    unsigned width = 1 + w.below(kMostPixels), height = 1 + w.below(kMostPixels);
    OptixDenoiserSizes sizes{};
    w.done("optixDenoiserComputeMemoryResources",
           optixDenoiserComputeMemoryResources(denoiser, w.nearly(width), w.nearly(height),
                                               w.chance(97) ? &sizes : nullptr));
    if (sizes.withOverlapScratchSizeInBytes > (size_t(16) << 20))
        return;
    size_t scratchSize = sizes.withoutOverlapScratchSizeInBytes;
    CUdeviceptr state = w.address(sizes.stateSizeInBytes), scratch = w.address(scratchSize);
    w.done("optixDenoiserSetup",
           optixDenoiserSetup(denoiser, w.stream(), w.nearly(width), w.nearly(height), state,
                              w.nearlySize(sizes.stateSizeInBytes), scratch,
                              w.nearlySize(scratchSize)));
    OptixDenoiserParams params{};
    params.denoiseAlpha = w.chance(90) ? w.below(3) : w.any32();
    params.blendFactor = w.chance(80) ? 0.0f : w.anyFloat();
    if (w.chance(30))
        params.hdrIntensity =
            w.chance(80) ? w.upload(std::vector<float>{w.anyFloat()}) / 4 * 4 : w.address(4, 4);
    if (w.chance(30))
        params.hdrAverageColor =
            w.chance(80) ? w.upload(std::vector<float>{1.0f, w.anyFloat(), 2.0f}) / 4 * 4
                         : w.address(12, 4);
    OptixDenoiserGuideLayer guides{image(w, width, height), image(w, width, height),
                                   image(w, width, height, true)};
#if FUZZ_76
    params.temporalModeUsePreviousLayers = w.chance(90) ? w.below(2) : w.any32();
    guides.previousOutputInternalGuideLayer = image(w, width, height);
    guides.outputInternalGuideLayer = image(w, width, height);
#endif
    OptixDenoiserLayer layers[2];
    // All images of a call have one format, as a rule.
    for (OptixDenoiserLayer& layer : layers) {
        layer = {image(w, width, height), image(w, width, height), image(w, width, height)};
        if (w.chance(92))
            layer.output.format = layer.previousOutput.format = layer.input.format;
        if (w.chance(20))
            layer.output = layer.input;
    }
    unsigned count = w.chance(90) ? 1 + w.below(2) : 0;
    w.done("optixDenoiserInvoke",
           optixDenoiserInvoke(denoiser, w.stream(), w.chance(97) ? &params : nullptr, state,
                               w.nearlySize(sizes.stateSizeInBytes),
                               w.chance(95) ? &guides : nullptr, w.chance(97) ? layers : nullptr,
                               count, w.chance(90) ? 0 : w.any32(), w.chance(90) ? 0 : w.any32(),
                               w.chance(97) ? scratch : w.address(scratchSize),
                               w.nearlySize(scratchSize)));
}
const Call kDenoise{"optixDenoiserInvoke", 6, denoise};

void statistics(World& w) {
    OptixImage2D input = image(w, 1 + w.below(kMostPixels), 1 + w.below(kMostPixels));
    OptixDenoiser denoiser = w.pick(w.denoisers);
    size_t scratchSize = w.chance(90) ? 1 << 16 : w.below(64);
    CUdeviceptr scratch = w.address(scratchSize);
    auto function = w.chance(50) ? optixDenoiserComputeIntensity : optixDenoiserComputeAverageColor;
    w.done("optixDenoiserCompute*", function(denoiser, w.stream(), w.chance(97) ? &input : nullptr,
                                             w.address(12, 4), scratch, scratchSize));
}
const Call kStatistics{"optixDenoiserComputeIntensity", 2, statistics};

} // namespace
} // namespace fuzz
