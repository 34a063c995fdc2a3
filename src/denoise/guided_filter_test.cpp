// SPDX-License-Identifier: Apache-2.0
#include "denoise/guided_filter.h"

#include "denoise/rows/rows.h"
#include "denoise/test_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>
#include <vector>

namespace sunstone::denoise::test {
namespace {

constexpr uint32_t kWidth = 256, kHeight = 160;

const Rendering& truth() {
    static const Rendering picture = Tracer().render(kWidth, kHeight, 512, 1000);
    return picture;
}

struct Guides {
    bool albedo = true, normal = true;
};

Frame frameOf(Rendering& r, Picture& output, Guides guides = {}) {
    Frame frame;
    if (guides.albedo)
        frame.albedo = r.albedo.image();
    if (guides.normal)
        frame.normal = r.normal.image();
    frame.layers.push_back({r.color.image(), {}, output.image()});
    return frame;
}

void runFilter(const Frame& frame, const FilterSettings& settings = {}, uint32_t factor = 1) {
    GuidedFilter filter(settings, factor);
    const Image& input = frame.layers[0].input;
    // Garbage in scratch must not matter.
    std::vector<uint8_t> scratch(filter.scratchSize(input.width, input.height), 0xff);
    filter.run(frame, scratch.data());
}

Picture denoised(Rendering& r, Guides guides = {}, const FilterSettings& settings = {}) {
    Picture output(r.color.width, r.color.height);
    runFilter(frameOf(r, output, guides), settings);
    return output;
}

TEST(GuidedFilter, GainsSixDecibelsOnFourSamples) {
    for (uint32_t seed : {7u, 8u}) {
        Rendering noisy = Tracer().render(kWidth, kHeight, 4, seed);
        double before = psnr(noisy.color, truth().color);
        for (Guides guides :
             {Guides{true, true}, Guides{true, false}, Guides{false, true}, Guides{false, false}}) {
            double after = psnr(denoised(noisy, guides), truth().color);
            EXPECT_GE(after, before + 6.0)
                << "albedo " << guides.albedo << ", normal " << guides.normal << ", seed " << seed;
        }
    }
}

TEST(GuidedFilter, GainsOnVeryNoisyPictures) {
    Rendering noisy = Tracer().render(kWidth, kHeight, 1, 9);
    EXPECT_GE(psnr(denoised(noisy), truth().color), psnr(noisy.color, truth().color) + 6.0);
}

// A picture of one colour with noise, and guides with an edge in the middle.
struct EdgeScene {
    static constexpr uint32_t kSize = 48;
    Rendering noisy{Picture(kSize, kSize), Picture(kSize, kSize), Picture(kSize, kSize)};
    float sides[2];

    EdgeScene(float left, float right, bool inAlbedo, float noise) : sides{left, right} {
        std::mt19937 random(3);
        std::uniform_real_distribution<float> offset(-noise, noise);
        for (uint32_t y = 0; y < kSize; ++y)
            for (uint32_t x = 0; x < kSize; ++x) {
                bool side = x >= kSize / 2;
                float* guide = (inAlbedo ? noisy.albedo : noisy.normal).at(x, y);
                guide[0] = side ? 0.8f : 0.3f;
                for (int c = 0; c < 3; ++c)
                    noisy.color.at(x, y)[c] = sides[side] + offset(random);
            }
    }
    // Mean of a column.
    static float column(const Picture& picture, uint32_t x) {
        float sum = 0;
        for (uint32_t y = 0; y < kSize; ++y)
            sum += picture.at(x, y)[1];
        return sum / kSize;
    }
};

TEST(GuidedFilter, KeepsEdgesOfGuides) {
    for (bool inAlbedo : {true, false}) {
        // The noise is larger than the step: only the guide shows the edge.
        EdgeScene scene(0.40f, 0.55f, inAlbedo, 0.35f);
        Picture with = denoised(scene.noisy, {inAlbedo, !inAlbedo});
        Picture without = denoised(scene.noisy, {false, false});
        uint32_t middle = EdgeScene::kSize / 2;
        float step = EdgeScene::column(with, middle) - EdgeScene::column(with, middle - 1);
        float blurred = EdgeScene::column(without, middle) - EdgeScene::column(without, middle - 1);
        EXPECT_GT(step, 0.10f) << "in albedo: " << inAlbedo;
        EXPECT_LT(blurred, 0.06f) << "without a guide there is nothing to keep";
    }
}

TEST(GuidedFilter, KeepsShadingThatNormalsExplain) {
    // Bumps finer than any pass of the filter, under noise that hides them.
    constexpr uint32_t kSide = 64;
    Rendering clean{Picture(kSide, kSide), Picture(kSide, kSide), Picture(kSide, kSide)};
    Rendering noisy = clean;
    std::mt19937 random(5);
    std::normal_distribution<float> noise(0.0f, 0.15f);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            float slope = 0.3f * std::sin(1.5f * float(x));
            noisy.normal.at(x, y)[0] = slope;
            for (int c = 0; c < 3; ++c) {
                clean.color.at(x, y)[c] = 0.5f + 0.6f * slope;
                noisy.color.at(x, y)[c] = clean.color.at(x, y)[c] + noise(random);
            }
        }
    double with = psnr(denoised(noisy, {false, true}), clean.color);
    double without = psnr(denoised(noisy, {false, false}), clean.color);
    EXPECT_GT(with, psnr(noisy.color, clean.color) + 8.0);
    EXPECT_GT(with, without + 3.0);
}

TEST(GuidedFilter, AveragesLimitedColorsAsLight) {
    // A surface whose pixels have either full light or none, encoded for a screen.
    constexpr uint32_t kSide = 48;
    Rendering noisy{Picture(kSide, kSide), Picture(kSide, kSide), Picture(kSide, kSide)};
    std::mt19937 random(6);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            float light = float(random() % 1000) / 1000.0f;
            for (int c = 0; c < 3; ++c)
                noisy.color.at(x, y)[c] = std::pow(light * light, 1 / 2.2f);
        }
    Picture output(kSide, kSide);
    Frame frame = frameOf(noisy, output, {false, false});
    frame.isLimited = true;
    runFilter(frame);
    double sum = 0.0;
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x)
            sum += std::pow(output.at(x, y)[1], 2.2f);
    // The mean of light * light is 1/3; the mean of the encoded values decodes to 0.27.
    EXPECT_NEAR(sum / (kSide * kSide), 0.333, 0.025);
}

// Single dark pixels that no guide shows, far below the noise around them (bright ones are cut as
// fireflies). Neighbours' differences are not alike; boxes separate them from noise.
TEST(GuidedFilter, KeepsSparsePoints) {
    constexpr uint32_t kSide = 60, kEvery = 12;
    constexpr float kGround = 0.5f, kDepth = 0.2f;
    Rendering noisy{Picture(kSide, kSide), Picture(kSide, kSide), Picture(kSide, kSide)};
    std::mt19937 random(11);
    std::normal_distribution<float> noise(0.0f, 0.01f);
    const auto isPoint = [](uint32_t x, uint32_t y) {
        return x % kEvery == kEvery / 2 && y % kEvery == kEvery / 2;
    };
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x)
            for (int c = 0; c < 3; ++c)
                noisy.color.at(x, y)[c] = kGround - (isPoint(x, y) ? kDepth : 0) + noise(random);
    const Picture result = denoised(noisy, {false, false});
    float depth = 0;
    unsigned points = 0;
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x)
            if (isPoint(x, y)) {
                depth += kGround - result.at(x, y)[1];
                ++points;
            }
    EXPECT_GT(depth / float(points), 0.5f * kDepth);
}

TEST(GuidedFilter, LeavesNoiselessPicturesAlone) {
    Rendering clean = truth();
    EXPECT_GT(psnr(denoised(clean), clean.color), 38.0);
    Rendering flat{Picture(33, 17), Picture(33, 17), Picture(33, 17)};
    for (float& value : flat.color.values)
        value = 0.25f;
    for (float value : denoised(flat).values)
        EXPECT_NEAR(value, 0.25f, 1e-6f);
}

// Each pixel factor x factor times.
Picture enlarged(const Picture& picture, uint32_t factor) {
    Picture large(factor * picture.width, factor * picture.height);
    for (uint32_t y = 0; y < large.height; ++y)
        for (uint32_t x = 0; x < large.width; ++x)
            std::copy_n(picture.at(x / factor, y / factor), 4, large.at(x, y));
    return large;
}

class GuidedFilterTiles : public testing::TestWithParam<std::tuple<uint32_t, bool>> {};

TEST_P(GuidedFilterTiles, GiveWhatTheWholeGives) {
    auto [factor, temporal] = GetParam();
    Rendering noisy = Tracer().render(kWidth, kHeight, 4, 11);
    FilterSettings settings;
    settings.passes = 3; // so that the overlap is a small part of the picture
    GuidedFilter filter(settings, factor);
    uint32_t overlap = filter.overlap();
    ASSERT_LT(overlap * 2, kHeight);
    Picture flow(kWidth, kHeight), whole(factor * kWidth, factor * kHeight), tiled = whole;
    Picture previous = enlarged(truth().color, factor);
    for (size_t i = 0; i < flow.values.size(); i += 4) {
        flow.values[i] = 1.3f;
        flow.values[i + 1] = -2.0f;
    }
    Frame frame = frameOf(noisy, whole);
    frame.isTemporal = temporal;
    frame.flow = flow.image();
    frame.layers[0].previous = previous.image();
    runFilter(frame, settings, factor);
    constexpr uint32_t kTile = 61;
    for (uint32_t y = 0; y < kHeight; y += kTile)
        for (uint32_t x = 0; x < kWidth; x += kTile) {
            uint32_t left = x - std::min(x, overlap), top = y - std::min(y, overlap);
            uint32_t right = std::min(kWidth, x + kTile + overlap);
            uint32_t bottom = std::min(kHeight, y + kTile + overlap);
            auto cut = [&](Picture& p) {
                uint32_t f = p.width / kWidth;
                return p.part(f * left, f * top, f * (right - left), f * (bottom - top));
            };
            Frame tile = frame;
            tile.albedo = cut(noisy.albedo);
            tile.normal = cut(noisy.normal);
            tile.flow = cut(flow);
            tile.layers[0].input = cut(noisy.color);
            tile.layers[0].previous = cut(previous);
            tile.layers[0].output =
                tiled.part(factor * x, factor * y, factor * std::min(kTile, kWidth - x),
                           factor * std::min(kTile, kHeight - y));
            tile.offsetX = x - left;
            tile.offsetY = y - top;
            runFilter(tile, settings, factor);
        }
    EXPECT_EQ(whole.values, tiled.values);
}

INSTANTIATE_TEST_SUITE_P(Factors, GuidedFilterTiles,
                         testing::Combine(testing::Values(1u, 2u), testing::Bool()));

TEST(GuidedFilter, AnySize) {
    const uint32_t sizes[][2] = {{1, 1}, {1, 7}, {9, 1}, {2, 2}, {5, 3}, {257, 2}, {16, 16}};
    for (auto [width, height] : sizes) {
        Rendering noisy = Tracer().render(width, height, 2, 5);
        Picture output = denoised(noisy);
        for (float value : output.values)
            EXPECT_TRUE(std::isfinite(value)) << width << " x " << height;
        if (width * height == 1)
            EXPECT_NEAR(output.values[0], noisy.color.values[0], 1e-5f);
    }
}

TEST(GuidedFilter, RepairsValuesThatAreNotFinite) {
    Rendering noisy = Tracer().render(64, 48, 4, 12);
    Rendering broken = noisy;
    const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f};
    for (uint32_t i = 0; i < 40; ++i) {
        uint32_t x = (i * 29) % 64, y = (i * 17) % 48;
        broken.color.at(x, y)[i % 3] = bad[i % 4];
        broken.albedo.at(y, x % 48)[i % 3] = bad[i % 3];
        broken.normal.at(x, y)[i % 2] = bad[(i + 1) % 3];
    }
    Picture expected = denoised(noisy), output = denoised(broken);
    for (float value : output.values)
        ASSERT_TRUE(std::isfinite(value));
    EXPECT_GT(psnr(output, expected), 25.0);
    for (size_t i = 0; i < broken.color.values.size(); ++i)
        broken.color.values[i] = i % 4 == 3 ? 1.0f : NAN;
    output = denoised(broken);
    for (size_t i = 0; i < output.values.size(); ++i)
        ASSERT_EQ(i % 4 == 3 ? 1.0f : 0.0f, output.values[i]);
}

TEST(GuidedFilter, CutsFireflies) {
    Rendering noisy = Tracer().render(96, 64, 16, 13);
    Rendering truthful = Tracer().render(96, 64, 256, 14);
    for (uint32_t i = 0; i < 60; ++i)
        for (int c = 0; c < 3; ++c)
            noisy.color.at((i * 37 + 11) % 96, (i * 23 + 5) % 64)[c] = 500.0f;
    double before = psnr(noisy.color, truthful.color);
    EXPECT_LT(before, 27.0);
    EXPECT_GT(psnr(denoised(noisy), truthful.color), before + 6.0);
}

TEST(GuidedFilter, SameBitsOnEveryInstructionSetAndRun) {
    Rendering noisy = Tracer().render(130, 40, 4, 15);
    Picture first = denoised(noisy);
    EXPECT_EQ(first.values, denoised(noisy).values);
    // Tests the kernels themselves, on arbitrary numbers.
    constexpr uint32_t kSide = 70;
    constexpr size_t kStride = 80, kPlane = kStride * kSide;
    std::mt19937 random(4);
    std::uniform_real_distribution<float> value(0, 2);
    std::vector<float> source(kPlane * 12), results[2];
    for (float& v : source)
        v = value(random);
    const RowKernels* kernels[2] = {&baseRowKernels(), &rowKernels()};
    for (int k = 0; k < 2; ++k) {
        results[k].assign(kPlane * 13, 0.0f);
        auto plane = [&](std::vector<float>& from, size_t i) { return from.data() + i * kPlane; };
        auto planes = [&](std::vector<float>& from, size_t i) {
            return Planes{{plane(from, i), plane(from, i + 1), plane(from, i + 2)},
                          plane(from, i + 3),
                          plane(from, i + 4)};
        };
        Pass pass{};
        pass.width = kSide;
        pass.height = kSide;
        pass.stride = kStride;
        pass.guideCount = 5;
        for (size_t g = 0; g < kMaxGuides; ++g)
            pass.guides[g] = plane(source, 5 + g);
        pass.valid = plane(source, 11);
        pass.from = planes(source, 0);
        pass.to = planes(results[k], 0);
        pass.pilot = planes(results[k], 5);
        pass.colorTolerance = 1;
        pass.hasAlpha = true;
        for (uint32_t y = 0; y < kSide; ++y) {
            kernels[k]->residual(pass, y);
            kernels[k]->spread(pass, y);
        }
        for (size_t c = 0; c < 3; ++c)
            pass.detail[c] = plane(results[k], 10 + c);
        for (uint32_t y = 0; y < kSide; ++y)
            kernels[k]->detail(pass, y);
        pass.pilot = pass.from;
        for (pass.step = 1; pass.step < 32; pass.step *= 2)
            for (uint32_t y = 0; y < kSide; ++y)
                kernels[k]->smooth(pass, y);
    }
    EXPECT_EQ(results[0], results[1]);
}

TEST(GuidedFilter, OutputMayBeTheInput) {
    Rendering noisy = Tracer().render(80, 60, 4, 16);
    for (float blend : {0.0f, 0.25f}) {
        Picture apart(80, 60);
        Frame frame = frameOf(noisy, apart);
        frame.blend = blend;
        runFilter(frame);
        Rendering copy = noisy;
        Frame inPlace = frameOf(copy, copy.color);
        inPlace.blend = blend;
        runFilter(inPlace);
        EXPECT_EQ(apart.values, copy.color.values);
    }
}

TEST(GuidedFilter, ABlendOfOneIsTheInputBitForBit) {
    Rendering noisy = Tracer().render(80, 60, 4, 18);
    Picture output(80, 60);
    Frame frame = frameOf(noisy, output);
    frame.blend = 1;
    runFilter(frame);
    EXPECT_EQ(output.values, noisy.color.values);
}

TEST(GuidedFilter, AlphaModes) {
    Rendering noisy = Tracer().render(64, 64, 4, 17);
    std::mt19937 random(6);
    std::uniform_real_distribution<float> alpha(0, 1);
    for (size_t i = 3; i < noisy.color.values.size(); i += 4)
        noisy.color.values[i] = alpha(random);
    auto spread = [](const Picture& p) {
        double sum = 0, squares = 0;
        for (size_t i = 3; i < p.values.size(); i += 4) {
            sum += p.values[i];
            squares += double(p.values[i]) * p.values[i];
        }
        double n = double(p.values.size() / 4);
        return squares / n - (sum / n) * (sum / n);
    };
    Picture outputs[3];
    for (int i = 0; i < 3; ++i) {
        outputs[i] = Picture(64, 64);
        Frame frame = frameOf(noisy, outputs[i]);
        frame.alpha = AlphaMode(i);
        runFilter(frame);
    }
    for (size_t i = 3; i < outputs[0].values.size(); i += 4)
        ASSERT_EQ(noisy.color.values[i], outputs[0].values[i]);
    EXPECT_LT(spread(outputs[1]), 0.3 * spread(noisy.color));
    EXPECT_LT(spread(outputs[2]), 0.3 * spread(noisy.color));
    for (size_t i = 0; i < outputs[0].values.size(); ++i) // colours do not depend on it
        if (i % 4 != 3)
            ASSERT_EQ(outputs[0].values[i], outputs[2].values[i]);
}

TEST(GuidedFilter, BrightnessDoesNotMatter) {
    Rendering noisy = Tracer().render(96, 64, 4, 18);
    Picture expected = denoised(noisy);
    Rendering dark = noisy;
    for (size_t i = 0; i < dark.color.values.size(); ++i)
        if (i % 4 != 3)
            dark.color.values[i] *= 0x1p-20f;
    Picture output(96, 64);
    Frame frame = frameOf(dark, output);
    for (float& scale : frame.scale)
        scale = 0x1p20f;
    runFilter(frame);
    for (size_t i = 0; i < output.values.size(); ++i)
        if (i % 4 != 3)
            output.values[i] *= 0x1p20f;
    EXPECT_EQ(expected.values, output.values);
}

// ---- Temporal -----------------------------------------------------------------------------------

struct Sequence {
    Picture previous, flow;
    FilterSettings settings;

    Picture next(Rendering& noisy) {
        Picture output(noisy.color.width, noisy.color.height);
        Frame frame = frameOf(noisy, output);
        frame.isTemporal = true;
        frame.flow = flow.image();
        frame.layers[0].previous = previous.image();
        runFilter(frame, settings);
        previous = output;
        return output;
    }
};

TEST(GuidedFilterTemporal, FramesGrowBetter) {
    Sequence sequence;
    sequence.flow = Picture(kWidth, kHeight);
    std::fill(sequence.flow.values.begin(), sequence.flow.values.end(), 0.0f);
    double first = 0, last = 0, single = 0;
    for (uint32_t i = 0; i < 6; ++i) {
        Rendering noisy = Tracer().render(kWidth, kHeight, 4, 30 + i);
        if (i == 0)
            sequence.previous = noisy.color; // as a client may pass without a previous one
        single = psnr(denoised(noisy), truth().color);
        last = psnr(sequence.next(noisy), truth().color);
        if (i == 0)
            first = last;
    }
    EXPECT_GT(first, psnr(Tracer().render(kWidth, kHeight, 4, 30).color, truth().color) + 5.0);
    EXPECT_GT(last, single + 0.7) << "first frame " << first;
}

TEST(GuidedFilterTemporal, FollowsTheFlowAndForgetsWhatDoesNotFit) {
    // Vertical stripes that move 5 pixels a frame, hardly noisy.
    constexpr uint32_t kSide = 64;
    auto stripes = [&](uint32_t shift, float noise) {
        Rendering r{Picture(kSide, kSide), Picture(kSide, kSide), Picture(kSide, kSide)};
        std::mt19937 random(shift);
        std::uniform_real_distribution<float> offset(-noise, noise);
        for (uint32_t y = 0; y < kSide; ++y)
            for (uint32_t x = 0; x < kSide; ++x)
                for (int c = 0; c < 3; ++c)
                    r.color.at(x, y)[c] =
                        (((x + kSide - shift) / 8) % 2 ? 0.7f : 0.2f) + offset(random);
        return r;
    };
    Rendering clean = stripes(5, 0), noisy = stripes(5, 0.05f);
    double errors[2];
    for (int right = 0; right < 2; ++right) {
        Sequence sequence;
        sequence.previous = stripes(0, 0).color;
        sequence.flow = Picture(kSide, kSide);
        for (size_t i = 0; i < sequence.flow.values.size(); i += 4)
            sequence.flow.values[i] = right ? 5.0f : 0.0f;
        errors[right] = psnr(sequence.next(noisy), clean.color);
    }
    EXPECT_GT(errors[1], errors[0]);
    EXPECT_GT(errors[0], 28.0) << "a wrong flow must not leave ghosts; they would cost 10 dB";
    Sequence broken;
    broken.previous = Picture(kSide, kSide);
    broken.flow = Picture(kSide, kSide);
    for (size_t i = 0; i < broken.flow.values.size(); ++i) {
        broken.previous.values[i] = i % 3 ? NAN : INFINITY;
        broken.flow.values[i] = i % 5 ? float(i) - 9e3f : NAN;
    }
    for (float value : broken.next(noisy).values)
        ASSERT_TRUE(std::isfinite(value));
}

} // namespace
} // namespace sunstone::denoise::test
