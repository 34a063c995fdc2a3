// SPDX-License-Identifier: Apache-2.0
#include "png_image.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace {

float srgbCurve(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

// x (1 + x / w^2) / (1 + x): Reinhard's curve with white at w (Reinhard et al. 2002).
float filmicCurve(float linear) {
    constexpr float kWhite = 2.0f;
    return linear * (1.0f + linear / (kWhite * kWhite)) / (1.0f + linear);
}

} // namespace

std::vector<uint8_t> toSrgb(const std::vector<float>& linear, bool filmic) {
    std::vector<uint8_t> rgba(linear.size() / 4 * 4);
    for (size_t i = 0; i < rgba.size(); ++i) {
        float value = linear[i];
        if (!(value > 0.0f)) // also NaN
            value = 0.0f;
        if (filmic)
            value = filmicCurve(std::min(value, 1e6f));
        float encoded = srgbCurve(std::min(value, 1.0f));
        rgba[i] = i % 4 == 3 ? 255 : uint8_t(encoded * 255.0f + 0.5f);
    }
    return rgba;
}

void writePng(const std::string& path, unsigned width, unsigned height,
              const std::vector<uint8_t>& rgba) {
    if (width == 0 || height == 0 || rgba.size() != size_t(width) * height * 4)
        throw std::runtime_error("cannot write " + path + ": the picture's size is wrong");
    png_image image;
    std::memset(&image, 0, sizeof(image));
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = PNG_FORMAT_RGBA;
    if (!png_image_write_to_file(&image, path.c_str(), 0, rgba.data(), 0, nullptr))
        throw std::runtime_error("cannot write " + path + ": " + image.message);
}
