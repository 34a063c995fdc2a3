// SPDX-License-Identifier: Apache-2.0
// Pixel formats, statistics and the model container.
#include "denoise/image.h"
#include "denoise/model.h"
#include "denoise/statistics.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

namespace sunstone::denoise {
namespace {

TEST(Image, EveryHalfSurvives) {
    for (uint32_t bits = 0; bits < 0x10000; ++bits) {
        float value = halfToFloat(uint16_t(bits));
        uint32_t magnitude = bits & 0x7fff;
        if (magnitude > 0x7c00)
            EXPECT_TRUE(std::isnan(value) && std::isnan(halfToFloat(floatToHalf(value))));
        else if (magnitude == 0x7c00)
            EXPECT_EQ((bits & 0x8000) | 0x7bff, floatToHalf(value)); // the largest half
        else
            EXPECT_EQ(bits, floatToHalf(value));
    }
    EXPECT_EQ(1.0f, halfToFloat(0x3c00));
    EXPECT_EQ(0x1p-24f, halfToFloat(1));
    EXPECT_EQ(65504.0f, halfToFloat(0x7bff));
}

TEST(Image, HalvesRoundToTheNearestEven) {
    for (uint32_t bits = 0; bits < 0x7bff; ++bits) {
        float low = halfToFloat(uint16_t(bits)), high = halfToFloat(uint16_t(bits + 1));
        float middle = low + (high - low) * 0.5f;
        EXPECT_EQ(bits & 1 ? bits + 1 : bits, floatToHalf(middle)) << bits;
        EXPECT_EQ(bits + 1, floatToHalf(std::nextafter(middle, INFINITY))) << bits;
    }
}

TEST(Image, FormatsRoundTrip) {
    for (Format format : {Format::kHalf2, Format::kHalf3, Format::kHalf4, Format::kFloat2,
                          Format::kFloat3, Format::kFloat4, Format::kByte3, Format::kByte4}) {
        std::vector<uint8_t> memory(64, 0xee);
        Image image{memory.data() + 1, 2, 2, 33 - 4, pixelSizeOf(format), format}; // unaligned
        float values[4] = {0.2f, 0.4f, 0.6f, 0.8f}, back[4] = {9, 9, 9, 9};
        if (29 < 2 * pixelSizeOf(format))
            image.width = 1;
        writePixel(image, image.width - 1, 1, values);
        readPixel(image, image.width - 1, 1, back);
        for (unsigned c = 0; c < 4; ++c) {
            if (c < channelsOf(format))
                EXPECT_NEAR(values[c], back[c], 1e-3f);
            else
                EXPECT_EQ(9, back[c]);
        }
        EXPECT_EQ(0xee, memory[0]);
    }
    uint8_t bytes[3];
    Image image{bytes, 1, 1, 3, 3, Format::kByte3};
    writePixel(image, 0, 0, {-1.0f, NAN, 2.0f, 0.0f});
    EXPECT_EQ(0, bytes[0]);
    EXPECT_EQ(0, bytes[1]);
    EXPECT_EQ(255, bytes[2]);
}

TEST(Statistics, Formulas) {
    std::vector<float> pixels = {1, 2, 3, 0, 0, 0, 0.5f, 0.25f, 4, NAN, 1, 1};
    Image image{reinterpret_cast<uint8_t*>(pixels.data()), 4, 1, 48, 12, Format::kFloat3};
    auto light = [&](int i) {
        return pixels[size_t(i)] * 0.212586f + pixels[size_t(i) + 1] * 0.715170f +
               pixels[size_t(i) + 2] * 0.072200f;
    };
    EXPECT_NEAR(0.18 / std::exp((std::log(light(0)) + std::log(light(6))) / 2),
                intensityScale(image), 1e-6);
    float average[3];
    averageLogColor(image, average);
    EXPECT_NEAR((std::log(1.0) + std::log(0.5)) / 2, average[0], 1e-6);
    EXPECT_NEAR((std::log(2.0) + std::log(0.25) + std::log(1.0)) / 3, average[1], 1e-6);
    EXPECT_NEAR((std::log(3.0) + std::log(4.0) + std::log(1.0)) / 3, average[2], 1e-6);
    std::vector<float> black(12, 0.0f);
    image.data = reinterpret_cast<uint8_t*>(black.data());
    EXPECT_EQ(1.0f, intensityScale(image));
    averageLogColor(image, average);
    EXPECT_EQ(0.0f, average[0]);
}

TEST(Statistics, LogarithmAndExponential) {
    for (float x = 1e-8f; x < 3e38f; x *= 1.0037f)
        ASSERT_NEAR(std::log(double(x)), logarithm(double(x)), 5e-15 * (1 + std::abs(std::log(x))));
    EXPECT_EQ(0.0, logarithm(1.0));
    for (double x = -699.0; x < 700.0; x += 0.37)
        ASSERT_NEAR(1.0, exponential(x) / std::exp(x), 1e-12) << x;
    EXPECT_EQ(1.0, exponential(0.0));
    EXPECT_EQ(exponential(700.0), exponential(INFINITY));
    EXPECT_EQ(exponential(-700.0), exponential(-INFINITY));
    EXPECT_TRUE(std::isnan(exponential(NAN)));
}

std::vector<uint8_t> container(std::vector<uint32_t> words) {
    std::vector<uint8_t> bytes = {'S', 'U', 'N', 'D', 'E', 'N', 'O', 'I'};
    for (uint32_t word : words)
        for (int i = 0; i < 4; ++i)
            bytes.push_back(uint8_t(word >> (8 * i)));
    uint32_t hash = 2166136261u;
    for (uint8_t byte : bytes)
        hash = (hash ^ byte) * 16777619u;
    for (int i = 0; i < 4; ++i)
        bytes.push_back(uint8_t(hash >> (8 * i)));
    return bytes;
}

uint32_t word(float value) {
    return std::bit_cast<uint32_t>(value);
}

TEST(Model, Container) {
    const std::vector<uint32_t> good = {1, 56,         1,          1,          4,         3,
                                        3, word(1.5f), word(0.2f), word(0.3f), word(0.5f)};
    Model model;
    std::string reason;
    std::vector<uint8_t> bytes = container(good);
    ASSERT_TRUE(parseModel(bytes.data(), bytes.size(), model, reason)) << reason;
    EXPECT_EQ(Kind::kTemporalLayers, model.kind);
    EXPECT_TRUE(model.usesAlbedo && model.usesNormal);
    EXPECT_EQ(3u, model.settings.passes);
    EXPECT_EQ(0.5f, model.settings.historyWeight);
    for (size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(parseModel(bytes.data(), size, model, reason));
    for (size_t i = 0; i < bytes.size(); ++i) { // any changed byte is noticed
        std::vector<uint8_t> changed = bytes;
        changed[i] ^= 0x10;
        EXPECT_FALSE(parseModel(changed.data(), changed.size(), model, reason)) << i;
        EXPECT_FALSE(reason.empty());
    }
    const std::pair<size_t, uint32_t> faults[] = {
        {0, 2}, {1, 57}, {2, 0}, {2, 2},           {3, 7},         {4, 5},          {5, 4},
        {6, 0}, {6, 6},  {7, 0}, {8, word(-1.0f)}, {9, word(NAN)}, {10, word(1.0f)}};
    for (auto [index, value] : faults) {
        std::vector<uint32_t> words = good;
        words[index] = value;
        std::vector<uint8_t> wrong = container(words);
        EXPECT_FALSE(parseModel(wrong.data(), wrong.size(), model, reason)) << index;
    }
}

} // namespace
} // namespace sunstone::denoise
