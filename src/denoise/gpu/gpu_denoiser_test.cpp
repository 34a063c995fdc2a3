// SPDX-License-Identifier: Apache-2.0
// The denoiser's kernels, run on the CPU device, against the CPU's filter: all outputs have equal
// bits, except in NaN.
#include "denoise/gpu/gpu_denoiser.h"

#include "denoise/guided_filter.h"
#include "denoise/structure_predictor.h"
#include "denoise/test_scene.h"
#include "denoise/tone_mapper.h"
#include "device/cuda/test_driver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

namespace sunstone::denoise::gpu {
namespace {

using device::cuda::testDriver;
using namespace denoise::test;

GpuDenoiser& denoiser() {
    static GpuDenoiser made(testDriver());
    return made;
}

// An image of any format that owns its bytes; rows and pixels may have gaps.
struct Bytes {
    Image image;
    std::vector<uint8_t> memory;

    Bytes(uint32_t width, uint32_t height, Format format, size_t offset = 0, size_t gap = 0) {
        const size_t pixel = pixelSizeOf(format), row = width * pixel + gap;
        memory.assign(offset + height * row, 0xA5);
        image = {memory.data() + offset, width, height, row, pixel, format};
    }
    Bytes(const Bytes& other) : image(other.image), memory(other.memory) {
        image.data = memory.data() + (other.image.data - other.memory.data());
    }
};

void put(Bytes& to, const Picture& picture) {
    for (uint32_t y = 0; y < to.image.height; ++y)
        for (uint32_t x = 0; x < to.image.width; ++x) {
            float values[4];
            std::copy_n(picture.at(x, y), 4, values);
            writePixel(to.image, x, y, values);
        }
}

// Bytes of both are the same, or both are NaN.
void expectSame(const Bytes& expected, const Bytes& actual, const std::string& what) {
    ASSERT_EQ(expected.memory.size(), actual.memory.size()) << what;
    if (expected.memory == actual.memory)
        return;
    for (uint32_t y = 0; y < expected.image.height; ++y)
        for (uint32_t x = 0; x < expected.image.width; ++x) {
            float a[4] = {}, b[4] = {};
            readPixel(expected.image, x, y, a);
            readPixel(actual.image, x, y, b);
            for (unsigned c = 0; c < channelsOf(expected.image.format); ++c)
                ASSERT_TRUE(std::memcmp(&a[c], &b[c], 4) == 0 ||
                            (std::isnan(a[c]) && std::isnan(b[c])))
                    << what << ": channel " << c << " of pixel (" << x << ", " << y << ") is "
                    << b[c] << " instead of " << a[c];
        }
}

State stateFor(const Frame& frame) {
    return {kStateMagic, frame.layers[0].input.width, frame.layers[0].input.height};
}

void runOnGpu(const Filter& filter, const Frame& frame, CallInputs inputs,
              CUstream stream = nullptr) {
    const Image& input = frame.layers[0].input;
    inputs.width = input.width;
    inputs.height = input.height;
    // Neither the contents nor the address of scratch must matter.
    std::vector<uint8_t> scratch(filter.scratchSize(input.width, input.height) + 1, 0xff);
    denoiser().filter(stream, filter, frame, scratch.data() + 1, inputs);
    ASSERT_EQ(CUDA_SUCCESS, testDriver().streamSynchronize(stream));
}

void runOnCpu(const Filter& filter, const Frame& frame) {
    const Image& input = frame.layers[0].input;
    std::vector<uint8_t> scratch(filter.scratchSize(input.width, input.height));
    filter.run(frame, scratch.data());
}

struct Variant {
    const char* name;
    bool isLimited = false, isTemporal = false;
    uint32_t factor = 1, layers = 1;
    AlphaMode alpha = AlphaMode::kCopy;
    float blend = 0;
    bool albedo = true, normal = true;
    Format color = Format::kFloat4, output = Format::kFloat4, guide = Format::kFloat3,
           flow = Format::kFloat2;
    bool hasBadPixels = false;
};

Picture noise(uint32_t width, uint32_t height, uint32_t seed, float low, float high) {
    Picture picture(width, height);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> value(low, high);
    for (float& v : picture.values)
        v = value(random);
    return picture;
}

// All images of a frame: a rendered scene, and the images of temporal kinds.
struct Images {
    Bytes albedo, normal, flow;
    std::vector<Bytes> inputs, previous, outputs;

    Images(const Variant& v, uint32_t width, uint32_t height, uint32_t seed)
        : albedo(width, height, v.guide, 1, 3), normal(width, height, v.guide),
          flow(width, height, v.flow) {
        Rendering scene = Tracer().render(width, height, 2, seed);
        put(albedo, scene.albedo);
        put(normal, scene.normal);
        put(flow, noise(width, height, seed, -3, 3));
        for (uint32_t i = 0; i < v.layers; ++i) {
            Picture color = i == 0 ? scene.color : noise(width, height, seed + i, 0, 2);
            const Picture alpha = noise(width, height, seed + 9 + i, 0, 1);
            for (size_t p = 3; p < color.values.size(); p += 4)
                color.values[p] = alpha.values[p];
            if (v.hasBadPixels)
                spoil(color, seed + i);
            inputs.emplace_back(width, height, v.color, 0, 5);
            put(inputs.back(), color);
            previous.emplace_back(width * v.factor, height * v.factor, v.output);
            put(previous.back(), noise(width * v.factor, height * v.factor, seed + 20, 0, 1));
            outputs.emplace_back(width * v.factor, height * v.factor, v.output, 2, 7);
        }
    }
    static void spoil(Picture& picture, uint32_t seed) {
        constexpr float kBad[] = {NAN, INFINITY, -INFINITY, 3e38f, 1e30f, -0.0f, 1e-40f};
        std::mt19937 random(seed);
        for (size_t i = 0; i < picture.values.size() / 10; ++i)
            picture.values[random() % picture.values.size()] = kBad[random() % 7];
    }

    Frame frame(const Variant& v) const {
        Frame frame;
        if (v.albedo)
            frame.albedo = albedo.image;
        if (v.normal)
            frame.normal = normal.image;
        frame.isLimited = v.isLimited;
        frame.isTemporal = v.isTemporal;
        if (v.isTemporal)
            frame.flow = flow.image;
        frame.alpha = v.alpha;
        frame.blend = v.blend;
        for (size_t i = 0; i < inputs.size(); ++i)
            frame.layers.push_back(
                {inputs[i].image, v.isTemporal ? previous[i].image : Image(), outputs[i].image});
        return frame;
    }
};

const Variant kVariants[] = {
    {.name = "LDR", .isLimited = true},
    {.name = "LDR, bytes",
     .isLimited = true,
     .blend = 0.25f,
     .color = Format::kByte4,
     .output = Format::kByte3,
     .guide = Format::kHalf3},
    {.name = "HDR"},
    {.name = "HDR, alpha apart", .alpha = AlphaMode::kSeparate},
    {.name = "HDR, albedo, half",
     .blend = 0.5f,
     .normal = false,
     .color = Format::kHalf4,
     .output = Format::kHalf4,
     .guide = Format::kHalf4},
    {.name = "HDR, normals", .albedo = false, .color = Format::kFloat3, .output = Format::kHalf3},
    {.name = "HDR, no guides", .albedo = false, .normal = false, .hasBadPixels = true},
    {.name = "HDR, bad pixels", .alpha = AlphaMode::kSeparate, .hasBadPixels = true},
    {.name = "AOV", .layers = 3, .alpha = AlphaMode::kTogether},
    {.name = "AOV, bad pixels",
     .layers = 2,
     .alpha = AlphaMode::kTogether,
     .blend = 0.125f,
     .hasBadPixels = true},
    {.name = "temporal", .isTemporal = true},
    {.name = "temporal, bad pixels",
     .isTemporal = true,
     .blend = 0.5f,
     .flow = Format::kHalf2,
     .hasBadPixels = true},
    {.name = "temporal AOV, normals",
     .isTemporal = true,
     .layers = 2,
     .alpha = AlphaMode::kTogether,
     .albedo = false},
    {.name = "upscaling", .factor = 2, .layers = 2, .alpha = AlphaMode::kTogether, .blend = 0.5f},
    {.name = "upscaling, temporal, bad pixels",
     .isTemporal = true,
     .factor = 2,
     .alpha = AlphaMode::kSeparate,
     .hasBadPixels = true},
};

class GpuFilter : public testing::TestWithParam<Variant> {};

TEST_P(GpuFilter, HasTheBitsOfTheCpu) {
    const Variant& v = GetParam();
    const uint32_t sizes[][2] = {{67, 45}, {1, 1}, {3, 2}, {1, 40}, {33, 1}};
    const GuidedFilter filter(FilterSettings{}, v.factor);
    for (auto [width, height] : sizes) {
        const Images expected(v, width, height, 3);
        Images actual = expected;
        Frame frame = expected.frame(v);
        const float factor = 1.75f;
        std::fill_n(frame.scale, 3, factor);
        runOnCpu(filter, frame);
        frame = actual.frame(v);
        const State state = stateFor(frame);
        runOnGpu(filter, frame, {.state = &state, .intensity = &factor});
        for (size_t i = 0; i < expected.outputs.size(); ++i)
            expectSame(expected.outputs[i], actual.outputs[i],
                       message(v.name, ", ", width, " x ", height, ", layer ", i));
    }
}

INSTANTIATE_TEST_SUITE_P(Variants, GpuFilter, testing::ValuesIn(kVariants),
                         [](const auto& info) { return std::to_string(info.index); });

// The first frame has no previous one; each later one reads the frame before and overwrites it.
TEST(GpuDenoiser, SequencesHaveTheBitsOfTheCpu) {
    const GuidedFilter filter{FilterSettings{}};
    const Variant v{.name = "temporal", .isTemporal = true};
    constexpr uint32_t kWidth = 50, kHeight = 30;
    Bytes history(kWidth, kHeight, Format::kFloat4);
    Bytes histories[2] = {history, history};
    for (uint32_t i = 0; i < 3; ++i)
        for (const bool onGpu : {false, true}) {
            const Images images(v, kWidth, kHeight, 40 + i);
            Frame frame = images.frame(v);
            frame.hasPrevious = i != 0;
            frame.layers[0].previous = frame.layers[0].output = histories[onGpu].image;
            const State state = stateFor(frame);
            if (onGpu)
                runOnGpu(filter, frame, {.state = &state});
            else
                runOnCpu(filter, frame);
        }
    EXPECT_NE(history.memory, histories[0].memory);
    expectSame(histories[0], histories[1], "third frame");
}

TEST(GpuDenoiser, TilesGiveWhatTheWholeGives) {
    const GuidedFilter filter({.passes = 1});
    const Variant v{.name = "tiles"};
    constexpr uint32_t kWidth = 90, kHeight = 70, kTile = 40;
    const Images whole(v, kWidth, kHeight, 5);
    const Images tiled = whole;
    const Frame frame = whole.frame(v), parts = tiled.frame(v);
    const State state = stateFor(frame);
    runOnGpu(filter, frame, {.state = &state});
    const uint32_t overlap = filter.overlap();
    for (uint32_t y = 0; y < kHeight; y += kTile)
        for (uint32_t x = 0; x < kWidth; x += kTile) {
            const uint32_t left = x - std::min(x, overlap), top = y - std::min(y, overlap);
            const auto cut = [](Image image, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
                image.data = image.pixel(x0, y0);
                image.width = std::min(x1, image.width) - x0;
                image.height = std::min(y1, image.height) - y0;
                return image;
            };
            const auto input = [&](const Image& image) {
                return cut(image, left, top, x + kTile + overlap, y + kTile + overlap);
            };
            Frame tile = parts;
            tile.albedo = input(tile.albedo);
            tile.normal = input(tile.normal);
            tile.layers[0].input = input(tile.layers[0].input);
            tile.layers[0].output = cut(tile.layers[0].output, x, y, x + kTile, y + kTile);
            tile.offsetX = x - left;
            tile.offsetY = y - top;
            runOnGpu(filter, tile, {.state = &state});
        }
    expectSame(whole.outputs[0], tiled.outputs[0], "tiles");
}

TEST(GpuDenoiser, RemovesNoise) {
    Rendering noisy = Tracer().render(256, 160, 4, 7);
    const Picture truth = Tracer().render(256, 160, 256, 1000).color;
    Picture output(256, 160);
    Frame frame;
    frame.albedo = noisy.albedo.image();
    frame.normal = noisy.normal.image();
    frame.layers.push_back({noisy.color.image(), {}, output.image()});
    const State state = stateFor(frame);
    runOnGpu(GuidedFilter{FilterSettings{}}, frame, {.state = &state});
    EXPECT_GE(psnr(output, truth), psnr(noisy.color, truth) + 6.0);
}

TEST(GpuDenoiser, ScalesByTheAverageColor) {
    const GuidedFilter filter{FilterSettings{}};
    const Variant v{.name = "average colour"};
    const Images expected(v, 40, 20, 5);
    const Images actual = expected;
    const float average[3] = {-3.0f, 0.5f, 2.0f};
    Frame frame = expected.frame(v);
    for (int c = 0; c < 3; ++c) {
        frame.scale[c] = float(0.18 / exponential(double(average[c])));
        EXPECT_NEAR(0.18 / std::exp(average[c]), frame.scale[c], 1e-7);
    }
    runOnCpu(filter, frame);
    frame = actual.frame(v);
    const State state = stateFor(frame);
    const float notUsed = NAN;
    runOnGpu(filter, frame, {.state = &state, .intensity = &notUsed, .averageColor = average});
    expectSame(expected.outputs[0], actual.outputs[0], "scaled");
}

TEST(GpuDenoiser, ToneMapsWithTheBitsOfTheCpu) {
    const ToneMapper filter(1.3f, 2.2f);
    for (const Format format : {Format::kFloat4, Format::kHalf3}) {
        const Variant v{.name = "tone mapper", .color = format, .hasBadPixels = true};
        const Images expected(v, 67, 45, 8);
        const Images actual = expected;
        runOnCpu(filter, expected.frame(v));
        const Frame frame = actual.frame(v);
        const State state = stateFor(frame);
        runOnGpu(filter, frame, {.state = &state});
        expectSame(expected.outputs[0], actual.outputs[0], "tone mapped");
    }
}

TEST(GpuDenoiser, PredictsStructureWithTheBitsOfTheCpu) {
    const StructurePredictor filter;
    for (const bool isLimited : {false, true}) {
        const Variant v{.name = "predictor", .isLimited = isLimited, .hasBadPixels = true};
        const Images images(v, 67, 45, 8);
        Bytes expected(5, 3, Format::kFloat4), actual = expected;
        const float factor = 1.75f;
        Frame frame = images.frame(v);
        std::fill_n(frame.scale, 3, factor);
        frame.layers[0].output = expected.image;
        runOnCpu(filter, frame);
        frame.layers[0].output = actual.image;
        const State state = stateFor(frame);
        runOnGpu(filter, frame, {.state = &state, .intensity = &factor});
        expectSame(expected, actual, message("limited ", isLimited));
    }
}

TEST(GpuDenoiser, RefusesWhatOnlyTheStreamFindsOut) {
    const GuidedFilter filter{FilterSettings{}};
    const Variant v{.name = "refused"};
    const Images images(v, 20, 10, 5);
    const std::vector<uint8_t> before = images.outputs[0].memory;
    const Frame frame = images.frame(v);
    EXPECT_TRUE(denoiser().takeRefusals().empty());
    const State overwritten{1, 20, 10}, small{kStateMagic, 20, 9}, good{kStateMagic, 20, 10};
    const float zero = 0.0f, average[3] = {0.0f, INFINITY, 0.0f};
    const struct {
        CallInputs inputs;
        const char* mention;
    } cases[] = {{{.state = &overwritten}, "overwritten"},
                 {{.state = &small}, "set up for 20 x 9 pixels, inputs have 20 x 10"},
                 {{.state = &good, .intensity = &zero}, "hdrIntensity gives a factor of 0"},
                 {{.state = &good, .averageColor = average}, "hdrAverageColor"}};
    const auto stream = reinterpret_cast<CUstream>(uintptr_t(2)); // the per-thread one
    for (const auto& c : cases) {
        runOnGpu(filter, frame, c.inputs, stream);
        EXPECT_EQ(before, images.outputs[0].memory) << c.mention;
        const auto refusals = denoiser().takeRefusals();
        ASSERT_EQ(1u, refusals.size()) << c.mention;
        EXPECT_EQ(stream, refusals[0].stream);
        EXPECT_NE(std::string::npos, refusals[0].text.find(c.mention)) << refusals[0].text;
    }
    runOnGpu(filter, frame, {.state = &good}, stream);
    EXPECT_TRUE(denoiser().takeRefusals().empty());
    EXPECT_NE(before, images.outputs[0].memory);
}

TEST(GpuDenoiser, RefusesWhatThreadsCannotCount) {
    uint8_t byte = 0;
    Frame frame;
    frame.layers.push_back({{&byte, 1u << 15, 1u << 15, 12u << 15, 12, Format::kFloat3}, {}, {}});
    try {
        denoiser().filter(nullptr, GuidedFilter{FilterSettings{}}, frame, &byte,
                          {.width = 1u << 15, .height = 1u << 15});
        FAIL() << "planes of 4 GiB were taken";
    } catch (const Error& error) {
        EXPECT_EQ(Code::kNotSupported, error.code());
        EXPECT_NE(nullptr, std::strstr(error.what(), "32768 x 32768"));
    }
}

TEST(GpuDenoiser, StatisticsHaveTheBitsOfTheCpu) {
    // One block, several blocks, more rows than there are blocks for.
    const uint32_t sizes[][2] = {{1, 1}, {3, 2}, {70, 30}, {200, 90}, {2, 5000}};
    for (auto [width, height] : sizes)
        for (Format format : {Format::kFloat4, Format::kHalf3}) {
            Picture picture = noise(width, height, width, 0, 40);
            if (width > 3)
                Images::spoil(picture, 4);
            Bytes bytes(width, height, format);
            put(bytes, picture);
            float average[3], averageOnGpu[3], intensityOnGpu = 0;
            averageLogColor(bytes.image, average);
            const size_t words = 3 + 3 * size_t(width) * height; // as the API asks for
            std::vector<uint8_t> scratch(4 * words + 1, 0xff);
            denoiser().intensity(nullptr, bytes.image, scratch.data() + 1, &intensityOnGpu);
            denoiser().averageColor(nullptr, bytes.image, scratch.data() + 1, averageOnGpu);
            ASSERT_EQ(CUDA_SUCCESS, testDriver().streamSynchronize(nullptr));
            EXPECT_EQ(intensityScale(bytes.image), intensityOnGpu) << width << " x " << height;
            EXPECT_EQ(0, std::memcmp(average, averageOnGpu, sizeof(average)));
        }
}

} // namespace
} // namespace sunstone::denoise::gpu
