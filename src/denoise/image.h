// SPDX-License-Identifier: Apache-2.0
// Images in a caller's memory: pixel formats, strides, conversion from and to floats. Compiled for
// CPUs and for threads of GPUs.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace sunstone::denoise {

enum class Format : uint8_t { kHalf2, kHalf3, kHalf4, kFloat2, kFloat3, kFloat4, kByte3, kByte4 };

inline unsigned channelsOf(Format format) {
    switch (format) {
    case Format::kHalf2:
    case Format::kFloat2:
        return 2;
    case Format::kHalf3:
    case Format::kFloat3:
    case Format::kByte3:
        return 3;
    case Format::kHalf4:
    case Format::kFloat4:
    case Format::kByte4:
        return 4;
    }
    return 0;
}

inline size_t channelSizeOf(Format format) {
    switch (format) {
    case Format::kHalf2:
    case Format::kHalf3:
    case Format::kHalf4:
        return 2;
    case Format::kFloat2:
    case Format::kFloat3:
    case Format::kFloat4:
        return 4;
    case Format::kByte3:
    case Format::kByte4:
        return 1;
    }
    return 0;
}

inline size_t pixelSizeOf(Format format) {
    return channelsOf(format) * channelSizeOf(format);
}

struct Image {
    uint8_t* data = nullptr; // null: no image
    uint32_t width = 0, height = 0;
    size_t rowStride = 0;
    size_t pixelStride = 0;
    Format format = Format::kFloat4;

    explicit operator bool() const { return data != nullptr; }
    uint8_t* pixel(uint32_t x, uint32_t y) const { return data + y * rowStride + x * pixelStride; }
};

// The nearest index in [0, size).
inline uint32_t clampTo(int value, uint32_t size) {
    return uint32_t(std::clamp(value, 0, int(size) - 1));
}

inline float halfToFloat(uint16_t half) {
    uint32_t sign = uint32_t(half & 0x8000u) << 16;
    uint32_t exponent = (half >> 10) & 31u;
    uint32_t fraction = half & 1023u;
    if (exponent == 31)
        return std::bit_cast<float>(sign | 0x7f800000u | (fraction << 13));
    if (exponent != 0)
        return std::bit_cast<float>(sign | ((exponent + 112u) << 23) | (fraction << 13));
    float tiny = float(fraction) * 0x1p-24f; // zero and subnormal halves
    return sign ? -tiny : tiny;
}

// Rounds to nearest even; values beyond the largest half become the largest half, NaN stays NaN.
inline uint16_t floatToHalf(float value) {
    uint32_t bits = std::bit_cast<uint32_t>(value);
    uint16_t sign = uint16_t((bits >> 16) & 0x8000u);
    float magnitude = std::bit_cast<float>(bits & 0x7fffffffu);
    if (magnitude != magnitude)
        return uint16_t(sign | 0x7e00u);
    if (magnitude >= 65504.0f)
        return uint16_t(sign | 0x7bffu);
    // Adding a power of two lets the addition round to the digits a half has.
    if (magnitude < 0x1p-14f) {
        uint32_t rounded = std::bit_cast<uint32_t>(magnitude + 0.5f) - 0x3f000000u;
        return uint16_t(sign | rounded);
    }
    uint32_t positive = std::bit_cast<uint32_t>(magnitude);
    positive += 0xfffu + ((positive >> 13) & 1u);
    return uint16_t(sign | ((positive >> 13) - (112u << 10)));
}

// One channel; strides may leave pixels unaligned.
template <class T>
T loadChannel(const uint8_t* pixel, unsigned channel) {
    const uint8_t* address = pixel + channel * sizeof(T);
#if defined(__NVPTX__) // which would load single bytes otherwise
    if (reinterpret_cast<uintptr_t>(address) % sizeof(T) == 0)
        return *reinterpret_cast<const T*>(address);
#endif
    T value;
    __builtin_memcpy(&value, address, sizeof(T));
    return value;
}
template <class T>
void storeChannel(uint8_t* pixel, unsigned channel, T value) {
    uint8_t* address = pixel + channel * sizeof(T);
#if defined(__NVPTX__)
    if (reinterpret_cast<uintptr_t>(address) % sizeof(T) == 0) {
        *reinterpret_cast<T*>(address) = value;
        return;
    }
#endif
    __builtin_memcpy(address, &value, sizeof(T));
}
inline uint8_t toByte(float value) {
    if (!(value > 0.0f)) // NaN too
        return 0;
    return value >= 1.0f ? 255 : uint8_t(value * 255.0f + 0.5f);
}

// A constant number of rounds, so that values stay in registers.
template <class Body>
inline void forChannels(unsigned count, Body body) {
    for (unsigned c = 0; c < 4; ++c)
        if (c < count)
            body(c);
}

// Channel values of one pixel; bytes are 0 to 1. Channels the format lacks keep their values.
inline void readPixel(const Image& image, uint32_t x, uint32_t y, float (&channels)[4]) {
    const uint8_t* from = image.pixel(x, y);
    unsigned count = channelsOf(image.format);
    switch (channelSizeOf(image.format)) {
    case 4:
        forChannels(count, [&](unsigned c) { channels[c] = loadChannel<float>(from, c); });
        break;
    case 2:
        forChannels(count,
                    [&](unsigned c) { channels[c] = halfToFloat(loadChannel<uint16_t>(from, c)); });
        break;
    default:
        forChannels(count, [&](unsigned c) { channels[c] = float(from[c]) * (1.0f / 255.0f); });
    }
}

// Writes the format's channels; bytes are clamped to 0 to 1 and rounded.
inline void writePixel(const Image& image, uint32_t x, uint32_t y, const float (&channels)[4]) {
    uint8_t* to = image.pixel(x, y);
    unsigned count = channelsOf(image.format);
    switch (channelSizeOf(image.format)) {
    case 4:
        forChannels(count, [&](unsigned c) { storeChannel<float>(to, c, channels[c]); });
        break;
    case 2:
        forChannels(count,
                    [&](unsigned c) { storeChannel<uint16_t>(to, c, floatToHalf(channels[c])); });
        break;
    default:
        forChannels(count, [&](unsigned c) { to[c] = toByte(channels[c]); });
    }
}

} // namespace sunstone::denoise
