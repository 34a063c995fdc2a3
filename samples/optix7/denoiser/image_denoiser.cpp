// SPDX-License-Identifier: Apache-2.0
#include "image_denoiser.h"

namespace {

#if OPTIX_VERSION >= 70600
constexpr bool kHasUpscaling = true;
constexpr auto kUpscale = OPTIX_DENOISER_MODEL_KIND_UPSCALE2X;
constexpr auto kTemporalUpscale = OPTIX_DENOISER_MODEL_KIND_TEMPORAL_UPSCALE2X;
#else
constexpr bool kHasUpscaling = false;
constexpr auto kUpscale = OPTIX_DENOISER_MODEL_KIND_AOV;
constexpr auto kTemporalUpscale = OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV;
#endif

bool isTemporal(OptixDenoiserModelKind kind) {
    return kind == OPTIX_DENOISER_MODEL_KIND_TEMPORAL ||
           kind == OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV || kind == kTemporalUpscale;
}

unsigned factorOf(OptixDenoiserModelKind kind) {
    return kHasUpscaling && (kind == kUpscale || kind == kTemporalUpscale) ? 2 : 1;
}

} // namespace

ImageDenoiser::ImageDenoiser(OptixDeviceContext context, OptixDenoiserModelKind kind,
                             bool withAlbedo, bool withNormal, unsigned width, unsigned height)
    : kind_(kind), withAlbedo_(withAlbedo), withNormal_(withNormal), width_(width), height_(height),
      factor_(factorOf(kind)) {
    OptixDenoiserOptions options = {};
    options.guideAlbedo = withAlbedo;
    options.guideNormal = withNormal;
    OPTIX_CHECK(optixDenoiserCreate(context, kind, &options, &denoiser_));
    OptixDenoiserSizes sizes = {};
    OPTIX_CHECK(optixDenoiserComputeMemoryResources(denoiser_, width, height, &sizes));
    state_.allocate(sizes.stateSizeInBytes);
    scratch_.allocate(sizes.withoutOverlapScratchSizeInBytes);
    intensity_.allocate(sizeof(float));
    OPTIX_CHECK(optixDenoiserSetup(denoiser_, nullptr, width, height, state_.address(),
                                   state_.size(), scratch_.address(), scratch_.size()));
}

ImageDenoiser::~ImageDenoiser() {
    if (denoiser_)
        optixDenoiserDestroy(denoiser_);
}

OptixImage2D ImageDenoiser::describe(const DeviceBuffer& memory, OptixPixelFormat format,
                                     unsigned factor) const {
    OptixImage2D image = {};
    image.data = memory.address();
    image.width = factor * width_;
    image.height = factor * height_;
    image.pixelStrideInBytes = format == OPTIX_PIXEL_FORMAT_FLOAT2 ? 8 : 16;
    image.rowStrideInBytes = image.width * image.pixelStrideInBytes;
    image.format = format;
    return image;
}

std::vector<std::vector<float>> ImageDenoiser::denoise(const NoisyImage& image) {
    size_t count = image.layers.size();
    bool isFirst = outputs_.empty();
    inputs_.resize(count);
    outputs_.resize(count);
    std::vector<OptixDenoiserLayer> layers(count);
    for (size_t i = 0; i < count; ++i) {
        inputs_[i].upload(image.layers[i]);
        if (isFirst && factor_ != 1)
            outputs_[i].allocate(factor_ * factor_ * image.layers[i].size() * sizeof(float));
        else if (isFirst) // the noisy image replaces the frame before the first
            outputs_[i].upload(image.layers[i]);
        layers[i].input = describe(inputs_[i], OPTIX_PIXEL_FORMAT_FLOAT4);
        layers[i].output = describe(outputs_[i], OPTIX_PIXEL_FORMAT_FLOAT4, factor_);
        if (isTemporal(kind_))
            layers[i].previousOutput = layers[i].output;
    }
    OptixDenoiserGuideLayer guides = {};
    if (withAlbedo_) {
        albedo_.upload(image.albedo);
        guides.albedo = describe(albedo_, OPTIX_PIXEL_FORMAT_FLOAT4);
    }
    if (withNormal_) {
        normal_.upload(image.normal);
        guides.normal = describe(normal_, OPTIX_PIXEL_FORMAT_FLOAT4);
    }
    if (isTemporal(kind_)) {
        flow_.upload(image.flow);
        guides.flow = describe(flow_, OPTIX_PIXEL_FORMAT_FLOAT2);
    }
    OptixDenoiserParams params = {};
#if OPTIX_VERSION >= 70600
    params.temporalModeUsePreviousLayers = !isFirst;
#endif
    if (kind_ == OPTIX_DENOISER_MODEL_KIND_HDR || factor_ != 1) {
        OPTIX_CHECK(optixDenoiserComputeIntensity(denoiser_, nullptr, &layers[0].input,
                                                  intensity_.address(), scratch_.address(),
                                                  scratch_.size()));
        params.hdrIntensity = intensity_.address();
    }
    OPTIX_CHECK(optixDenoiserInvoke(denoiser_, nullptr, &params, state_.address(), state_.size(),
                                    &guides, layers.data(), unsigned(count), 0, 0,
                                    scratch_.address(), scratch_.size()));
    CUDA_CHECK(cudaDeviceSynchronize());
    std::vector<std::vector<float>> results;
    for (const DeviceBuffer& output : outputs_)
        results.push_back(output.download<float>());
    return results;
}
