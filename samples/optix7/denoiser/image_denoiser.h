// SPDX-License-Identifier: Apache-2.0
// The denoiser for pictures in host memory: 4 floats a pixel, flow 2 floats a pixel.
#pragma once

#include "device_buffer.h"

#include <optix.h>

#include <vector>

struct NoisyImage {
    // The layers: the beauty image, then others (AOV kinds).
    std::vector<std::vector<float>> layers;
    std::vector<float> albedo, normal; // empty: no such guide
    std::vector<float> flow;           // temporal kinds
};

class ImageDenoiser {
public:
    ImageDenoiser(OptixDeviceContext context, OptixDenoiserModelKind kind, bool withAlbedo,
                  bool withNormal, unsigned width, unsigned height);
    ImageDenoiser(const ImageDenoiser&) = delete;
    ImageDenoiser& operator=(const ImageDenoiser&) = delete;
    ~ImageDenoiser();

    // The denoised layers; upscaling kinds (OptiX 7.6) make them twice as wide and high. Temporal
    // kinds take the images in the order of time.
    std::vector<std::vector<float>> denoise(const NoisyImage& image);

private:
    OptixImage2D describe(const DeviceBuffer& memory, OptixPixelFormat format,
                          unsigned factor = 1) const;

    OptixDenoiserModelKind kind_;
    bool withAlbedo_, withNormal_;
    unsigned width_, height_;
    unsigned factor_; // pixels of outputs for one of inputs, in each direction
    OptixDenoiser denoiser_ = nullptr;
    DeviceBuffer state_, scratch_, intensity_;
    DeviceBuffer albedo_, normal_, flow_;
    std::vector<DeviceBuffer> inputs_, outputs_; // outputs of one frame are the next one's history
};
