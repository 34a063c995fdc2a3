// SPDX-License-Identifier: Apache-2.0
// See fetch.h.
#include "texture/fetch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace sunstone::texture {

namespace {

template <class T>
T load(const uint8_t* address) {
    T value;
    std::memcpy(&value, address, sizeof value);
    return value;
}
uint32_t bits(float value) {
    return std::bit_cast<uint32_t>(value);
}

float fromSrgb(uint8_t value) {
    return srgbNumbers()[value];
}

template <class T>
float unit(T value, bool unclamped) {
    if constexpr (std::is_signed_v<T>)
        return std::max(unclamped ? -2.0f : -1.0f,
                        float(value) / float(std::numeric_limits<T>::max()));
    else
        return float(double(value) / double(std::numeric_limits<T>::max()));
}

template <class T>
uint32_t integerWord(T value, bool asFloat, bool unclamped) {
    return asFloat ? bits(unit(value, unclamped)) : uint32_t(int64_t(value));
}

template <class T>
void fetchIntegers(const Format& format, Reading reading, const uint8_t* texel, uint32_t words[4]) {
    const bool asFloat = (reading.asFloat || format.normalized) && sizeof(T) < 4;
    for (unsigned i = 0; i < format.channels; ++i)
        words[i] = integerWord(load<T>(texel + i * sizeof(T)), asFloat, reading.unclamped);
}

// Stores a colour as a signed or unsigned fraction.
template <class T>
void storeUnit(uint8_t* texel, float value) {
    const double low = std::is_signed_v<T> ? -1.0 : 0.0;
    const double most = double(std::numeric_limits<T>::max());
    const double clamped = value >= low ? std::min(double(value), 1.0) : low; // NaN becomes low
    const T stored = T(std::floor(clamped * most + 0.5));
    std::memcpy(texel, &stored, sizeof stored);
}

} // namespace

const float* srgbNumbers() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> values{};
        for (unsigned i = 0; i < 256; ++i) {
            const double c = i / 255.0;
            values[i] = float(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
        }
        return values;
    }();
    return table.data();
}

float halfToFloat(uint16_t half) {
    const uint32_t sign = uint32_t(half & 0x8000) << 16;
    const uint32_t exponent = half >> 10 & 31, mantissa = half & 1023;
    if (exponent == 31)
        return std::bit_cast<float>(sign | 0x7F800000u | mantissa << 13);
    if (exponent != 0)
        return std::bit_cast<float>(sign | (exponent + 112) << 23 | mantissa << 13);
    const float value = float(mantissa) * 0x1p-24f;
    return sign ? -value : value;
}

uint16_t floatToHalf(float value) {
    const uint32_t all = bits(value), sign = all >> 16 & 0x8000, magnitude = all & 0x7FFFFFFF;
    if (magnitude > 0x7F800000)
        return uint16_t(sign | 0x7FFF);
    if (magnitude >= 0x477FF000) // rounds to 65536 or more
        return uint16_t(sign | 0x7C00);
    if (magnitude < 0x38800000) // subnormal
        return uint16_t(sign | uint32_t(std::lrint(std::fabs(value) * 0x1p24f)));
    const uint32_t rounded = magnitude + 0xFFF + (magnitude >> 13 & 1);
    return uint16_t(sign | ((rounded - 0x38000000) >> 13));
}

void fetchTexel(const Format& format, Reading reading, const uint8_t* slice, size_t rowPitch,
                uint32_t x, uint32_t y, uint32_t words[4]) {
    words[0] = words[1] = words[2] = words[3] = 0;
    if (format.isBlock()) {
        float color[4];
        decodeBlock(format.channel, slice + y / 4 * rowPitch + x / 4 * format.elementBytes(), x % 4,
                    y % 4, color);
        const bool srgb = format.srgb || reading.srgb;
        for (unsigned i = 0; i < 4; ++i)
            words[i] =
                bits(srgb && i < 3 ? fromSrgb(uint8_t(std::lrint(color[i] * 255))) : color[i]);
        return;
    }
    const uint8_t* texel = slice + y * rowPitch + size_t(x) * format.elementBytes();
    switch (format.channel) {
    case Channel::kU8:
        fetchIntegers<uint8_t>(format, reading, texel, words);
        if ((reading.srgb || format.srgb) && (reading.asFloat || format.normalized))
            for (unsigned i = 0; i < (format.channels == 2 ? 1u : 3u) && i < format.channels; ++i)
                words[i] = bits(fromSrgb(texel[i])); // of two channels the second is not a colour
        return;
    case Channel::kU16:
        return fetchIntegers<uint16_t>(format, reading, texel, words);
    case Channel::kS8:
        return fetchIntegers<int8_t>(format, reading, texel, words);
    case Channel::kS16:
        return fetchIntegers<int16_t>(format, reading, texel, words);
    case Channel::kF16:
        for (unsigned i = 0; i < format.channels; ++i)
            words[i] = bits(halfToFloat(load<uint16_t>(texel + 2 * i)));
        return;
    default:
        std::memcpy(words, texel, 4u * format.channels);
        return;
    }
}

void borderTexel(const Format& format, Reading reading, const float color[4], uint32_t words[4]) {
    uint32_t raw[4];
    std::memcpy(raw, color, sizeof raw);
    if (format.isBlock()) {
        std::memcpy(words, raw, sizeof raw);
        return;
    }
    const bool asFloat = reading.asFloat || format.normalized;
    uint8_t texel[16] = {};
    for (unsigned i = 0; i < format.channels; ++i) {
        uint8_t* channel = texel + i * format.channelBytes();
        switch (asFloat ? format.channel : Channel::kF32) {
        case Channel::kU8:
            storeUnit<uint8_t>(channel, color[i]);
            break;
        case Channel::kU16:
            storeUnit<uint16_t>(channel, color[i]);
            break;
        case Channel::kS8:
            storeUnit<int8_t>(channel, color[i]);
            break;
        case Channel::kS16:
            storeUnit<int16_t>(channel, color[i]);
            break;
        default:
            if (format.channel == Channel::kF16) {
                const uint16_t half = floatToHalf(color[i]);
                std::memcpy(channel, &half, 2);
            } else {
                std::memcpy(channel, &raw[i], format.channelBytes());
            }
        }
    }
    reading.srgb = false;
    Format plain = format;
    plain.srgb = false;
    fetchTexel(plain, reading, texel, 0, 0, 0, words);
}

namespace {

// Converts a word for a formatted store: integers are clamped to their range, floats truncated to
// halves.
template <class T>
T limited(uint32_t word) {
    if constexpr (std::is_signed_v<T>)
        return T(std::clamp<int32_t>(int32_t(word), std::numeric_limits<T>::min(),
                                     std::numeric_limits<T>::max()));
    else
        return T(std::min<uint32_t>(word, std::numeric_limits<T>::max()));
}

uint16_t cutToHalf(float value) {
    const uint16_t nearest = floatToHalf(value);
    if ((nearest & 0x7FFF) > 0x7C00 || std::isinf(value))
        return nearest;
    return std::fabs(halfToFloat(nearest)) > std::fabs(value) ? uint16_t(nearest - 1) : nearest;
}

template <class T>
void storeAs(uint8_t* channel, T value) {
    std::memcpy(channel, &value, sizeof value);
}

} // namespace

void storeWords(const Format& format, uint8_t* texel, const uint32_t words[4]) {
    for (unsigned i = 0; i < format.channels; ++i) {
        uint8_t* channel = texel + i * format.channelBytes();
        switch (format.channel) {
        case Channel::kF16:
            storeAs(channel, cutToHalf(std::bit_cast<float>(words[i])));
            break;
        case Channel::kU8:
            storeAs(channel, limited<uint8_t>(words[i]));
            break;
        case Channel::kS8:
            storeAs(channel, limited<int8_t>(words[i]));
            break;
        case Channel::kU16:
            storeAs(channel, limited<uint16_t>(words[i]));
            break;
        case Channel::kS16:
            storeAs(channel, limited<int16_t>(words[i]));
            break;
        default:
            std::memcpy(channel, &words[i], format.channelBytes());
        }
    }
}

} // namespace sunstone::texture
