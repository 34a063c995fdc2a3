// SPDX-License-Identifier: Apache-2.0
#include "image_denoiser.h"

namespace {

bool isTemporal(OptixDenoiserModelKind kind) {
    return kind == OPTIX_DENOISER_MODEL_KIND_TEMPORAL ||
           kind == OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV;
}

} // namespace

ImageDenoiser::ImageDenoiser(OptixDeviceContext context, OptixDenoiserModelKind kind,
                             bool withAlbedo, bool withNormal, unsigned width, unsigned height)
    : kind_(kind), withAlbedo_(withAlbedo), withNormal_(withNormal), width_(width),
      height_(height) {
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

OptixImage2D ImageDenoiser::describe(const DeviceBuffer& memory, OptixPixelFormat format) const {
    OptixImage2D image = {};
    image.data = memory.address();
    image.width = width_;
    image.height = height_;
    image.pixelStrideInBytes = format == OPTIX_PIXEL_FORMAT_FLOAT2 ? 8 : 16;
    image.rowStrideInBytes = width_ * image.pixelStrideInBytes;
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
        if (isFirst) // the noisy image stands for the frame before the first
            outputs_[i].upload(image.layers[i]);
        layers[i].input = describe(inputs_[i], OPTIX_PIXEL_FORMAT_FLOAT4);
        layers[i].output = describe(outputs_[i], OPTIX_PIXEL_FORMAT_FLOAT4);
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
    if (kind_ == OPTIX_DENOISER_MODEL_KIND_HDR) {
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
