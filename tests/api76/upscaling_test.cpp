// SPDX-License-Identifier: Apache-2.0
// Denoisers of OptiX 7.5 and 7.6: upscaling kinds, their sizes, first frames, tiles, and all errors
// of images for upscaling denoisers.
#include "fixture.h"

#include "optix_denoiser_tiling.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

namespace tests::api {
namespace {

constexpr unsigned kWidth = 96, kHeight = 64;
constexpr OptixResult kRefused = OPTIX_ERROR_INVALID_VALUE;
constexpr OptixDenoiserModelKind kKinds[] = {OPTIX_DENOISER_MODEL_KIND_UPSCALE2X,
                                             OPTIX_DENOISER_MODEL_KIND_TEMPORAL_UPSCALE2X};

bool isTemporal(OptixDenoiserModelKind kind) {
    return kind == OPTIX_DENOISER_MODEL_KIND_TEMPORAL_UPSCALE2X;
}

struct TestImage {
    Buffer memory;
    OptixImage2D image{};

    TestImage(unsigned width, unsigned height,
              OptixPixelFormat format = OPTIX_PIXEL_FORMAT_FLOAT4) {
        image.width = width;
        image.height = height;
        image.format = format;
        image.rowStrideInBytes = width * optixUtilGetPixelStride(image);
        memory = Buffer(size_t(height) * image.rowStrideInBytes);
        image.data = memory.address();
    }
    float* at(unsigned x, unsigned y) const {
        return reinterpret_cast<float*>(image.data + size_t(y) * image.rowStrideInBytes +
                                        size_t(x) * optixUtilGetPixelStride(image));
    }
};

double errorOf(const TestImage& a, const TestImage& b) {
    double sum = 0;
    for (unsigned y = 0; y < a.image.height; ++y)
        for (unsigned x = 0; x < a.image.width; ++x)
            for (unsigned c = 0; c < 3; ++c)
                sum += std::pow(double(a.at(x, y)[c]) - b.at(x, y)[c], 2);
    return std::sqrt(sum / (3.0 * a.image.width * a.image.height));
}

bool isBright(float x, float y) { // a slanted edge, in pixels of the input
    return x * 0.9f + y * 0.45f > 0.6f * kWidth;
}

// A slanted edge under noise at input size, with guides that show it, and the same without noise at
// twice the size.
struct Pictures {
    TestImage noisy, albedo, normal, flow, clean, previous, output;

    Pictures()
        : noisy(kWidth, kHeight), albedo(kWidth, kHeight), normal(kWidth, kHeight),
          flow(kWidth, kHeight, OPTIX_PIXEL_FORMAT_FLOAT2), clean(2 * kWidth, 2 * kHeight),
          previous(2 * kWidth, 2 * kHeight), output(2 * kWidth, 2 * kHeight) {
        std::mt19937 random(1);
        std::uniform_real_distribution<float> noise(-0.15f, 0.15f);
        for (unsigned y = 0; y < 2 * kHeight; ++y)
            for (unsigned x = 0; x < 2 * kWidth; ++x) {
                float share = 0.0f;
                for (int i = 0; i < 16; ++i)
                    share += isBright((float(x) + 0.125f + 0.25f * float(i % 4)) / 2,
                                      (float(y) + 0.125f + 0.25f * float(i / 4)) / 2) /
                             16.0f;
                for (unsigned c = 0; c < 3; ++c) {
                    float value = 0.3f + 0.4f * share;
                    clean.at(x, y)[c] = value;
                    previous.at(x, y)[c] = value;
                    noisy.at(x / 2, y / 2)[c] += 0.25f * value;
                    albedo.at(x / 2, y / 2)[c] += 0.25f * (0.4f + 0.5f * share);
                }
                normal.at(x / 2, y / 2)[2] = 1.0f;
            }
        for (unsigned y = 0; y < kHeight; ++y)
            for (unsigned x = 0; x < kWidth; ++x) {
                for (unsigned c = 0; c < 3; ++c)
                    noisy.at(x, y)[c] += noise(random);
                noisy.at(x, y)[3] = float(x) / kWidth;
            }
    }
    OptixDenoiserGuideLayer guides() const {
        OptixDenoiserGuideLayer layer{};
        layer.albedo = albedo.image;
        layer.normal = normal.image;
        layer.flow = flow.image;
        return layer;
    }
    OptixDenoiserLayer layer() const { return {noisy.image, previous.image, output.image}; }
    // The alternative without an upscaling denoiser.
    TestImage bilinear(const TestImage& small) const {
        TestImage large(2 * kWidth, 2 * kHeight);
        for (unsigned y = 0; y < 2 * kHeight; ++y)
            for (unsigned x = 0; x < 2 * kWidth; ++x)
                for (int j = 0; j < 2; ++j)
                    for (int i = 0; i < 2; ++i) {
                        int column = int(x / 2) + i * (x % 2 ? 1 : -1);
                        int row = int(y / 2) + j * (y % 2 ? 1 : -1);
                        const float* from =
                            small.at(unsigned(std::clamp(column, 0, int(kWidth) - 1)),
                                     unsigned(std::clamp(row, 0, int(kHeight) - 1)));
                        for (unsigned c = 0; c < 4; ++c)
                            large.at(x, y)[c] +=
                                (i ? 0.25f : 0.75f) * (j ? 0.25f : 0.75f) * from[c];
                    }
        return large;
    }
};

class Upscaling : public ApiTest {
protected:
    void TearDown() override {
        if (denoiser_)
            EXPECT_OK(optixDenoiserDestroy(denoiser_));
        ApiTest::TearDown();
    }
    void create(OptixDenoiserModelKind kind) {
        if (denoiser_)
            ASSERT_OK(optixDenoiserDestroy(denoiser_));
        OptixDenoiserOptions options{1, 1};
        ASSERT_OK(optixDenoiserCreate(context_, kind, &options, &denoiser_));
        params_ = {};
        params_.temporalModeUsePreviousLayers = 1;
    }
    void setup(unsigned width = kWidth, unsigned height = kHeight) {
        ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser_, width, height, &sizes_));
        state_ = Buffer(sizes_.stateSizeInBytes);
        scratch_ = Buffer(sizes_.withoutOverlapScratchSizeInBytes);
        scratch_.fill(0xff);
        ASSERT_OK(optixDenoiserSetup(denoiser_, nullptr, width, height, state_.address(),
                                     state_.size(), scratch_.address(), scratch_.size()));
        wait(); // until the state is written, its memory has to stay
    }
    OptixResult invoke(const OptixDenoiserGuideLayer& guides, const OptixDenoiserLayer* layers,
                       unsigned count = 1, unsigned offsetX = 0, unsigned offsetY = 0) {
        OptixResult result = optixDenoiserInvoke(denoiser_, nullptr, &params_, state_.address(),
                                                 state_.size(), &guides, layers, count, offsetX,
                                                 offsetY, scratch_.address(), scratch_.size());
        wait();
        return result;
    }
    // Destroying a context waits for all work.
    static void wait() {
        OptixDeviceContext other = nullptr;
        ASSERT_EQ(OPTIX_SUCCESS, optixDeviceContextCreate(nullptr, nullptr, &other));
        ASSERT_EQ(OPTIX_SUCCESS, optixDeviceContextDestroy(other));
    }

    OptixDenoiser denoiser_ = nullptr;
    OptixDenoiserSizes sizes_{};
    OptixDenoiserParams params_{};
    Buffer state_, scratch_;
};

TEST_F(Upscaling, IsBetterThanInterpolatingWhatIsDenoised) {
    Pictures pictures;
    create(OPTIX_DENOISER_MODEL_KIND_AOV);
    setup();
    TestImage small(kWidth, kHeight);
    OptixDenoiserLayer plain{pictures.noisy.image, {}, small.image};
    ASSERT_OK(invoke(pictures.guides(), &plain));
    double bilinear = errorOf(pictures.bilinear(small), pictures.clean);
    for (OptixDenoiserModelKind kind : kKinds) {
        create(kind);
        setup();
        params_.temporalModeUsePreviousLayers = 0;
        OptixDenoiserLayer layer = pictures.layer();
        layer.previousOutput = {}; // a first frame has no predecessor
        pictures.output.memory.fill(0xff);
        ASSERT_OK(invoke(pictures.guides(), &layer));
        EXPECT_LT(errorOf(pictures.output, pictures.clean), 0.95 * bilinear) << kind;
        for (unsigned x = 2; x < 2 * kWidth - 2; ++x) // alpha in between
            ASSERT_NEAR((float(x) - 0.5f) / (2 * kWidth), pictures.output.at(x, 9)[3], 1e-5f);
    }
}

TEST_F(Upscaling, PreviousFramesHelp) {
    Pictures pictures;
    create(OPTIX_DENOISER_MODEL_KIND_TEMPORAL_UPSCALE2X);
    setup();
    OptixDenoiserLayer layer = pictures.layer();
    params_.temporalModeUsePreviousLayers = 0;
    ASSERT_OK(invoke(pictures.guides(), &layer));
    double alone = errorOf(pictures.output, pictures.clean);
    params_.temporalModeUsePreviousLayers = 1;
    ASSERT_OK(invoke(pictures.guides(), &layer));
    EXPECT_LT(errorOf(pictures.output, pictures.clean), 0.8 * alone);
    // Flow counts in pixels of the input: a previous image 3 of them to the left.
    TestImage moved(2 * kWidth, 2 * kHeight);
    for (unsigned y = 0; y < 2 * kHeight; ++y)
        for (unsigned x = 0; x < 2 * kWidth; ++x)
            std::memcpy(moved.at(x, y), pictures.clean.at(std::min(x + 6, 2 * kWidth - 1), y), 16);
    layer.previousOutput = moved.image;
    for (unsigned y = 0; y < kHeight; ++y)
        for (unsigned x = 0; x < kWidth; ++x)
            pictures.flow.at(x, y)[0] = 3.0f;
    ASSERT_OK(invoke(pictures.guides(), &layer));
    EXPECT_LT(errorOf(pictures.output, pictures.clean), 0.85 * alone);
    // The previous image may be written over.
    TestImage over(2 * kWidth, 2 * kHeight);
    std::memcpy(over.memory.as<char>(), moved.memory.as<char>(), moved.memory.size());
    layer.previousOutput = layer.output = over.image;
    ASSERT_OK(invoke(pictures.guides(), &layer));
    EXPECT_EQ(0, std::memcmp(over.memory.as<char>(), pictures.output.memory.as<char>(),
                             over.memory.size()));
}

TEST_F(Upscaling, LayersBlendingAndAlpha) {
    Pictures pictures, second;
    for (OptixDenoiserModelKind kind : kKinds) {
        create(kind);
        setup();
        for (OptixDenoiserAlphaMode mode :
             {OPTIX_DENOISER_ALPHA_MODE_COPY, OPTIX_DENOISER_ALPHA_MODE_ALPHA_AS_AOV,
              OPTIX_DENOISER_ALPHA_MODE_FULL_DENOISE_PASS}) {
            params_.denoiseAlpha = mode;
            OptixDenoiserLayer layers[2] = {pictures.layer(), second.layer()};
            // Internal guide layers have pixels of no bytes, and may be given.
            OptixDenoiserGuideLayer guides = pictures.guides();
            guides.outputInternalGuideLayer = pictures.output.image;
            guides.outputInternalGuideLayer.data = 0;
            guides.outputInternalGuideLayer.format = OPTIX_PIXEL_FORMAT_INTERNAL_GUIDE_LAYER;
            guides.outputInternalGuideLayer.pixelStrideInBytes =
                sizes_.internalGuideLayerPixelSizeInBytes;
            guides.previousOutputInternalGuideLayer = guides.outputInternalGuideLayer;
            ASSERT_OK(invoke(guides, layers, 2));
            EXPECT_LT(errorOf(second.output, second.clean), 0.05) << kind << ' ' << mode;
        }
        params_.blendFactor = 1.0f; // the input, each pixel four times
        OptixDenoiserLayer layer = pictures.layer();
        ASSERT_OK(invoke(pictures.guides(), &layer));
        for (unsigned i = 0; i < 40; ++i)
            for (unsigned c = 0; c < 3; ++c)
                ASSERT_NEAR(pictures.noisy.at(i, i)[c],
                            pictures.output.at(2 * i + i % 2, 2 * i + 1)[c], 1e-5f);
    }
}

TEST_F(Upscaling, MemoryResources) {
    create(OPTIX_DENOISER_MODEL_KIND_AOV);
    setup();
    OptixDenoiserSizes plain = sizes_;
    for (OptixDenoiserModelKind kind : kKinds) {
        create(kind);
        setup();
        EXPECT_GT(sizes_.withoutOverlapScratchSizeInBytes, plain.withoutOverlapScratchSizeInBytes);
        EXPECT_GE(sizes_.overlapWindowSizeInPixels, plain.overlapWindowSizeInPixels);
        size_t pixels = size_t(kWidth) * kHeight;
        EXPECT_GE(sizes_.computeAverageColorSizeInBytes, 4 * (3 + 3 * pixels));
        EXPECT_GE(sizes_.computeIntensitySizeInBytes, 4 * (2 + pixels));
        EXPECT_EQ(0u, sizes_.internalGuideLayerPixelSizeInBytes);
        EXPECT_REJECTED(kRefused, "optixDenoiserSetup", "scratchSizeInBytes",
                        optixDenoiserSetup(denoiser_, nullptr, kWidth, kHeight, state_.address(),
                                           state_.size(), scratch_.address(), scratch_.size() - 1));
        EXPECT_REJECTED(kRefused, "optixDenoiserSetup", "scratchSizeInBytes",
                        optixDenoiserSetup(denoiser_, nullptr, 2 * kWidth, 2 * kHeight,
                                           state_.address(), state_.size(), scratch_.address(),
                                           scratch_.size()));
    }
    Pictures pictures;
    Buffer average(12, 8), memory(sizes_.computeAverageColorSizeInBytes);
    EXPECT_OK(optixDenoiserComputeAverageColor(denoiser_, nullptr, &pictures.noisy.image,
                                               average.address(), memory.address(), memory.size()));
    params_.hdrAverageColor = average.address();
    OptixDenoiserLayer layer = pictures.layer();
    EXPECT_OK(invoke(pictures.guides(), &layer));
}

TEST_F(Upscaling, InvokeRefuses) {
    Pictures pictures;
    for (OptixDenoiserModelKind kind : kKinds) {
        create(kind);
        OptixDenoiserGuideLayer guides = pictures.guides();
        OptixDenoiserLayer layer = pictures.layer();
        EXPECT_REJECTED(OPTIX_ERROR_DENOISER_NOT_INITIALIZED, "optixDenoiserInvoke",
                        "optixDenoiserSetup", invoke(guides, &layer));
        setup();
        unsigned offset = 0;
        auto refuses = [&](const char* mention, const std::function<void()>& change) {
            guides = pictures.guides();
            layer = pictures.layer();
            offset = 0;
            change();
            EXPECT_REJECTED(kRefused, "optixDenoiserInvoke", mention,
                            invoke(guides, &layer, 1, offset));
        };
        refuses("output", [&] { layer.output.width -= 1; });
        refuses("output", [&] { layer.output.height -= 1; });
        refuses("output", [&] { offset = 1; });
        refuses("output", [&] { offset = kWidth; });
        refuses("output", [&] { layer.input.width -= 1; });
        refuses("output.data", [&] { layer.output.data = 64; });
        refuses("share memory",
                [&] { layer.input.data = layer.output.data + layer.output.rowStrideInBytes; });
        refuses("albedo", [&] { guides.albedo = pictures.clean.image; });
        refuses("normal", [&] { guides.normal = pictures.clean.image; });
        refuses("INTERNAL_GUIDE_LAYER",
                [&] { layer.input.format = OPTIX_PIXEL_FORMAT_INTERNAL_GUIDE_LAYER; });
        if (!isTemporal(kind))
            continue;
        refuses("flow", [&] { guides.flow = {}; });
        refuses("flow", [&] { guides.flow.width = 2 * kWidth; });
        refuses("previousOutput", [&] { layer.previousOutput = {}; });
        refuses("previousOutput", [&] { layer.previousOutput = pictures.noisy.image; });
    }
}

TEST_F(Upscaling, TiledEqualsWhole) {
    constexpr unsigned kTile = 24;
    Pictures pictures;
    for (OptixDenoiserModelKind kind : kKinds) {
        create(kind);
        setup();
        OptixDenoiserGuideLayer guides = pictures.guides();
        OptixDenoiserLayer layer = pictures.layer();
        ASSERT_OK(invoke(guides, &layer));
        TestImage tiled(2 * kWidth, 2 * kHeight);
        layer.output = tiled.image;
        unsigned overlap = sizes_.overlapWindowSizeInPixels, side = kTile + 2 * overlap;
        ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser_, kTile, kTile, &sizes_));
        Buffer scratch(sizes_.withOverlapScratchSizeInBytes);
        ASSERT_OK(optixDenoiserSetup(denoiser_, nullptr, side, side, state_.address(),
                                     state_.size(), scratch.address(), scratch.size()));
        ASSERT_OK(optixUtilDenoiserInvokeTiled(denoiser_, nullptr, &params_, state_.address(),
                                               state_.size(), &guides, &layer, 1, scratch.address(),
                                               scratch.size(), overlap, kTile, kTile));
        wait();
        EXPECT_EQ(0, std::memcmp(tiled.memory.as<char>(), pictures.output.memory.as<char>(),
                                 tiled.memory.size()))
            << kind;
        auto refused = [&](const OptixDenoiserLayer& bad) {
            return optixUtilDenoiserInvokeTiled(denoiser_, nullptr, &params_, state_.address(),
                                                state_.size(), &guides, &bad, 1, scratch.address(),
                                                scratch.size(), overlap, kTile, kTile);
        };
        OptixDenoiserLayer bad = layer;
        bad.output.width -= 2;
        EXPECT_EQ(kRefused, refused(bad));
        bad = layer;
        bad.previousOutput = pictures.noisy.image;
        EXPECT_EQ(kRefused, refused(bad));
    }
}

} // namespace
} // namespace tests::api
