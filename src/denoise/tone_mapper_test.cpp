// SPDX-License-Identifier: Apache-2.0
#include "denoise/tone_mapper.h"

#include "denoise/structure.h"
#include "denoise/structure_predictor.h"
#include "denoise/test_scene.h"
#include "denoise/tone_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

namespace sunstone::denoise::test {
namespace {

void run(const Filter& filter, const Frame& frame) {
    const Image& input = frame.layers[0].input;
    // Garbage in scratch must not matter, nor its address.
    std::vector<uint8_t> scratch(filter.scratchSize(input.width, input.height) + 1, 0xff);
    filter.run(frame, scratch.data() + 1);
}

TEST(ToneMap, PowersAreThoseOfTheMathematics) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> logarithms(-80.0, 0.0), exponents(0.05, 8.0);
    for (int i = 0; i < 100000; ++i) {
        const float value = float(std::exp(logarithms(random) / (i % 2 ? 1.0 : 20.0)));
        const float exponent = float(exponents(random));
        const double wanted = std::pow(double(value), double(exponent));
        const float power = powerOf(value, exponent);
        ASSERT_NEAR(power, wanted, 2e-7) << value << " ^ " << exponent;
        ASSERT_LE(power, 1.0f) << value << " ^ " << exponent;
        if (wanted > 1e-37) {
            const double x = std::log(wanted); // an error of x is one of the result
            ASSERT_NEAR(power / wanted, 1.0, 2e-7 - 2e-7 * x) << value << " ^ " << exponent;
        }
    }
    EXPECT_EQ(powerOf(1.0f, 0.3f), 1.0f);
    EXPECT_EQ(powerOf(1e-20f, 4.0f), 0.0f);
    EXPECT_EQ(powerOf(0.999999f, 1e-3f), 1.0f);
    EXPECT_EQ(toneMapped(1e-40f, 0.5f), 0.0f) << "a subnormal number";
}

TEST(ToneMapper, ExposesThenRaisesAndKeepsAlpha) {
    Picture picture(3, 2), result(3, 2);
    const float given[6][4] = {{0.5f, 0.25f, 0.125f, 0.5f},  {4.0f, 1.0f, 0.0f, 0.0f},
                               {-1.0f, NAN, INFINITY, 7.0f}, {1e-20f, 0.01f, 0.1f, 1.0f},
                               {0.5f, 0.5f, 0.5f, NAN},      {-INFINITY, -0.0f, 1e-42f, -2.0f}};
    std::copy_n(given[0], 24, picture.values.data());
    Frame frame;
    frame.layers.push_back({picture.image(), {}, result.image()});
    run(ToneMapper(0.5f, 2.2f), frame);
    for (int i = 0; i < 6; ++i)
        for (int c = 0; c < 3; ++c) {
            const double exposed = std::min(double(given[i][c]) * 0.5, 1.0);
            const double wanted = exposed > 0 ? std::pow(exposed, 1 / 2.2) : 0.0;
            EXPECT_NEAR(result.values[i * 4 + c], wanted, 3e-7) << i << " " << c;
        }
    for (int i = 0; i < 6; ++i)
        EXPECT_EQ(std::memcmp(&result.values[i * 4 + 3], &given[i][3], 4), 0) << i;
}

TEST(ToneMapper, TakesOtherFormatsAndItsOwnInput) {
    uint16_t halves[4 * 3];
    for (int i = 0; i < 12; ++i)
        halves[i] = floatToHalf(float(i) / 16.0f);
    Image image{reinterpret_cast<uint8_t*>(halves), 4, 1, 24, 6, Format::kHalf3};
    Frame frame;
    frame.layers.push_back({image, {}, image});
    run(ToneMapper(2.0f, 1.0f), frame);
    for (int i = 0; i < 12; ++i)
        EXPECT_EQ(halfToFloat(halves[i]), std::min(float(i) / 8.0f, 1.0f)) << i;
}

Picture predicted(Rendering& r, bool isLimited = false) {
    Picture blocks((r.color.width + 15) / 16, (r.color.height + 15) / 16);
    Frame frame;
    frame.albedo = r.albedo.image();
    frame.normal = r.normal.image();
    frame.isLimited = isLimited;
    frame.layers.push_back({r.color.image(), {}, blocks.image()});
    run(StructurePredictor(), frame);
    return blocks;
}

double meanOf(const Picture& picture) {
    double sum = 0;
    for (size_t i = 0; i < picture.values.size(); i += 4)
        sum += picture.values[i];
    return sum / double(picture.values.size() / 4);
}

// Similarity to the picture of many samples, by the same measure.
double measured(const Picture& noisy, const Picture& truth) {
    double sum = 0;
    uint32_t blocks = 0;
    const auto brightness = [](const float* c) {
        const float l = std::max(0.0f, c[0] * 0.212586f + c[1] * 0.715170f + c[2] * 0.0722f);
        return l / (1 + l);
    };
    for (uint32_t y = 0; y < noisy.height; y += kStructureBlock)
        for (uint32_t x = 0; x < noisy.width; x += kStructureBlock, ++blocks) {
            StructureSums sums;
            for (uint32_t v = y; v < std::min(y + kStructureBlock, noisy.height); ++v)
                for (uint32_t u = x; u < std::min(x + kStructureBlock, noisy.width); ++u)
                    sums.add(brightness(noisy.at(u, v)), brightness(truth.at(u, v)));
            sum += sums.similarity();
        }
    return sum / blocks;
}

TEST(StructurePredictor, PredictsWhatMoreSamplesWillShow) {
    constexpr uint32_t kWidth = 152, kHeight = 88; // no multiples of a block
    const Picture truth = Tracer().render(kWidth, kHeight, 256, 1000).color;
    double before = 0;
    for (const uint32_t samples : {1u, 4u, 16u}) {
        Rendering noisy = Tracer().render(kWidth, kHeight, samples, samples);
        const Picture blocks = predicted(noisy);
        EXPECT_EQ(blocks.width, 10u);
        const double mean = meanOf(blocks), actual = measured(noisy.color, truth);
        EXPECT_GT(mean, before) << samples;
        EXPECT_NEAR(mean, actual, 0.06) << samples;
        before = mean;
    }
    EXPECT_GT(before, 0.95);
}

TEST(StructurePredictor, EqualPixelsAreAlike) {
    Rendering plain{Picture(20, 17), Picture(20, 17), Picture(20, 17)};
    std::fill(plain.color.values.begin(), plain.color.values.end(), 0.5f);
    for (const bool isLimited : {false, true}) {
        const Picture blocks = predicted(plain, isLimited);
        ASSERT_EQ(blocks.values.size(), 2u * 2 * 4);
        for (const float value : blocks.values)
            EXPECT_NEAR(value, 1.0f, 1e-5f);
    }
}

} // namespace
} // namespace sunstone::denoise::test
