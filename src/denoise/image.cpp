// SPDX-License-Identifier: Apache-2.0
#include "denoise/image.h"

#include <bit>
#include <cstring>

namespace sunstone::denoise {
namespace {

constexpr float kLargestHalf = 65504.0f;

template <class T>
T load(const uint8_t* address, unsigned channel) {
    T value; // strides may leave pixels unaligned
    std::memcpy(&value, address + channel * sizeof(T), sizeof(T));
    return value;
}
template <class T>
void store(uint8_t* address, unsigned channel, T value) {
    std::memcpy(address + channel * sizeof(T), &value, sizeof(T));
}

uint8_t toByte(float value) {
    if (!(value > 0.0f)) // NaN too
        return 0;
    return value >= 1.0f ? 255 : uint8_t(value * 255.0f + 0.5f);
}

} // namespace

unsigned channelsOf(Format format) {
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

size_t channelSizeOf(Format format) {
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

float halfToFloat(uint16_t half) {
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

uint16_t floatToHalf(float value) {
    uint32_t bits = std::bit_cast<uint32_t>(value);
    uint16_t sign = uint16_t((bits >> 16) & 0x8000u);
    float magnitude = std::bit_cast<float>(bits & 0x7fffffffu);
    if (magnitude != magnitude)
        return uint16_t(sign | 0x7e00u);
    if (magnitude >= kLargestHalf)
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

void readPixel(const Image& image, uint32_t x, uint32_t y, float (&channels)[4]) {
    const uint8_t* from = image.pixel(x, y);
    unsigned count = channelsOf(image.format);
    switch (channelSizeOf(image.format)) {
    case 4:
        for (unsigned c = 0; c < count; ++c)
            channels[c] = load<float>(from, c);
        break;
    case 2:
        for (unsigned c = 0; c < count; ++c)
            channels[c] = halfToFloat(load<uint16_t>(from, c));
        break;
    default:
        for (unsigned c = 0; c < count; ++c)
            channels[c] = float(from[c]) * (1.0f / 255.0f);
    }
}

void writePixel(const Image& image, uint32_t x, uint32_t y, const float (&channels)[4]) {
    uint8_t* to = image.pixel(x, y);
    unsigned count = channelsOf(image.format);
    switch (channelSizeOf(image.format)) {
    case 4:
        for (unsigned c = 0; c < count; ++c)
            store<float>(to, c, channels[c]);
        break;
    case 2:
        for (unsigned c = 0; c < count; ++c)
            store<uint16_t>(to, c, floatToHalf(channels[c]));
        break;
    default:
        for (unsigned c = 0; c < count; ++c)
            to[c] = toByte(channels[c]);
    }
}

} // namespace sunstone::denoise
