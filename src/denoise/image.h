// SPDX-License-Identifier: Apache-2.0
// Images in a caller's memory: pixel formats, strides, conversion from and to rows of floats.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sunstone::denoise {

enum class Format : uint8_t { kHalf2, kHalf3, kHalf4, kFloat2, kFloat3, kFloat4, kByte3, kByte4 };

unsigned channelsOf(Format format);
size_t channelSizeOf(Format format);
inline size_t pixelSizeOf(Format format) {
    return channelsOf(format) * channelSizeOf(format);
}

struct Image {
    uint8_t* data = nullptr; // null: there is no such image
    uint32_t width = 0, height = 0;
    size_t rowStride = 0;
    size_t pixelStride = 0;
    Format format = Format::kFloat4;

    explicit operator bool() const { return data != nullptr; }
    uint8_t* pixel(uint32_t x, uint32_t y) const { return data + y * rowStride + x * pixelStride; }
};

float halfToFloat(uint16_t half);
// Rounds to nearest even; values beyond the largest half become the largest half, NaN stays NaN.
uint16_t floatToHalf(float value);

// Channel values of one pixel; bytes are 0 to 1. Channels the format lacks keep their values.
void readPixel(const Image& image, uint32_t x, uint32_t y, float (&channels)[4]);
// Writes the format's channels; bytes are clamped to 0 to 1 and rounded.
void writePixel(const Image& image, uint32_t x, uint32_t y, const float (&channels)[4]);

} // namespace sunstone::denoise
