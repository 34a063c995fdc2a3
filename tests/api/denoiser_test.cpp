// SPDX-License-Identifier: Apache-2.0
// The denoiser functions: the effect of each function, and every error.
#include "fixture.h"

#include "optix_denoiser_tiling.h"

#include <cmath>
#include <limits>
#include <random>

namespace tests::api {
namespace {

constexpr unsigned kWidth = 200, kHeight = 120;

unsigned channelsOf(OptixPixelFormat format) {
    switch (format) {
    case OPTIX_PIXEL_FORMAT_HALF2:
    case OPTIX_PIXEL_FORMAT_FLOAT2:
        return 2;
    case OPTIX_PIXEL_FORMAT_HALF4:
    case OPTIX_PIXEL_FORMAT_FLOAT4:
    case OPTIX_PIXEL_FORMAT_UCHAR4:
        return 4;
    default:
        return 3;
    }
}

// An image in memory of exactly its size.
struct TestImage {
    Buffer memory;
    OptixImage2D image{};

    TestImage(unsigned width, unsigned height, OptixPixelFormat format, unsigned padding = 0) {
        image.width = width;
        image.height = height;
        image.format = format;
        unsigned pixel = optixUtilGetPixelStride(image);
        image.rowStrideInBytes = width * pixel + padding;
        memory = Buffer(size_t(height - 1) * image.rowStrideInBytes + size_t(width) * pixel);
        image.data = memory.address();
    }
    float* at(unsigned x, unsigned y) const { // FLOAT formats
        return reinterpret_cast<float*>(image.data + size_t(y) * image.rowStrideInBytes +
                                        size_t(x) * optixUtilGetPixelStride(image));
    }
};

// A step between two colours under noise, with guides that show it.
struct Pictures {
    TestImage noisy, clean, albedo, normal, flow, output;

    explicit Pictures(unsigned width = kWidth, unsigned height = kHeight,
                      OptixPixelFormat format = OPTIX_PIXEL_FORMAT_FLOAT4)
        : noisy(width, height, format), clean(width, height, format),
          albedo(width, height, OPTIX_PIXEL_FORMAT_FLOAT3, 4),
          normal(width, height, OPTIX_PIXEL_FORMAT_FLOAT3),
          flow(width, height, OPTIX_PIXEL_FORMAT_FLOAT2), output(width, height, format) {
        std::mt19937 random(1);
        std::uniform_real_distribution<float> noise(-0.2f, 0.2f);
        for (unsigned y = 0; y < height; ++y)
            for (unsigned x = 0; x < width; ++x) {
                bool side = x * 2 >= width;
                for (unsigned c = 0; c < 3; ++c) {
                    float truth = side ? 0.7f : 0.3f;
                    clean.at(x, y)[c] = truth;
                    noisy.at(x, y)[c] = truth + noise(random);
                    albedo.at(x, y)[c] = side ? 0.9f : 0.4f;
                }
                if (channelsOf(format) == 4)
                    // Without a pattern, because the denoiser would keep a pattern.
                    noisy.at(x, y)[3] = clean.at(x, y)[3] =
                        float(((x * 2654435761u) ^ (y * 2246822519u)) * 3266489917u >> 28) / 16;
                normal.at(x, y)[side] = 1.0f;
            }
    }
    OptixDenoiserGuideLayer guides() const { return {albedo.image, normal.image, flow.image}; }
    OptixDenoiserLayer layer() const { return {noisy.image, noisy.image, output.image}; }

    // Root mean square difference of colours to the clean picture.
    static double error(const TestImage& a, const TestImage& b) {
        double sum = 0;
        for (unsigned y = 0; y < a.image.height; ++y)
            for (unsigned x = 0; x < a.image.width; ++x)
                for (unsigned c = 0; c < 3; ++c) {
                    double d = a.at(x, y)[c] - b.at(x, y)[c];
                    sum += d * d;
                }
        return std::sqrt(sum / (3.0 * a.image.width * a.image.height));
    }
};

class Denoiser : public ApiTest {
protected:
    void TearDown() override {
        if (denoiser_)
            EXPECT_OK(optixDenoiserDestroy(denoiser_));
        ApiTest::TearDown();
    }
    void create(OptixDenoiserModelKind kind, bool albedo = true, bool normal = true) {
        if (denoiser_)
            ASSERT_OK(optixDenoiserDestroy(denoiser_));
        OptixDenoiserOptions options{albedo, normal};
        ASSERT_OK(optixDenoiserCreate(context_, kind, &options, &denoiser_));
    }
    void setup(unsigned width = kWidth, unsigned height = kHeight) {
        ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser_, width, height, &sizes_));
        state_ = Buffer(sizes_.stateSizeInBytes);
        scratch_ = Buffer(sizes_.withoutOverlapScratchSizeInBytes);
        scratch_.fill(0xff);
        ASSERT_OK(optixDenoiserSetup(denoiser_, nullptr, width, height, state_.address(),
                                     state_.size(), scratch_.address(), scratch_.size()));
    }
    OptixResult invoke(const OptixDenoiserGuideLayer& guides, const OptixDenoiserLayer* layers,
                       unsigned count = 1, unsigned offsetX = 0, unsigned offsetY = 0) {
        OptixResult result = optixDenoiserInvoke(denoiser_, nullptr, &params_, state_.address(),
                                                 state_.size(), &guides, layers, count, offsetX,
                                                 offsetY, scratch_.address(), scratch_.size());
        wait();
        return result;
    }
    // The stream's next call returns the error of queued work, once.
    void expectStreamError(const char* mention) {
        auto next = [&] {
            return optixDenoiserSetup(denoiser_, nullptr, kWidth, kHeight, state_.address(),
                                      state_.size(), scratch_.address(), scratch_.size());
        };
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixDenoiserSetup", mention, next());
        EXPECT_OK(next());
        wait();
    }
    // Destroying a context waits for all work.
    static void wait() {
        OptixDeviceContext other = nullptr;
        ASSERT_EQ(OPTIX_SUCCESS, optixDeviceContextCreate(nullptr, nullptr, &other));
        ASSERT_EQ(OPTIX_SUCCESS, optixDeviceContextDestroy(other));
        hearReports();
    }

    OptixDenoiser denoiser_ = nullptr;
    OptixDenoiserSizes sizes_{};
    OptixDenoiserParams params_{};
    Buffer state_, scratch_;
};

constexpr OptixDenoiserModelKind kKinds[] = {
    OPTIX_DENOISER_MODEL_KIND_LDR, OPTIX_DENOISER_MODEL_KIND_HDR, OPTIX_DENOISER_MODEL_KIND_AOV,
    OPTIX_DENOISER_MODEL_KIND_TEMPORAL, OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV};

TEST_F(Denoiser, EveryKindRemovesNoise) {
    Pictures pictures;
    double before = Pictures::error(pictures.noisy, pictures.clean);
    for (OptixDenoiserModelKind kind : kKinds)
        for (bool guided : {false, true}) {
            create(kind, guided, guided);
            setup();
            pictures.output.memory.fill(0xff);
            OptixDenoiserLayer layer = pictures.layer();
            ASSERT_OK(invoke(pictures.guides(), &layer));
            EXPECT_LT(Pictures::error(pictures.output, pictures.clean), before * 0.5)
                << kind << ' ' << guided;
            for (unsigned x = 0; x < kWidth; ++x)
                ASSERT_EQ(pictures.noisy.at(x, 5)[3], pictures.output.at(x, 5)[3]);
        }
}

TEST_F(Denoiser, MemoryResources) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR);
    for (unsigned size : {1u, 64u, 1000u}) {
        OptixDenoiserSizes sizes{};
        ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser_, size, size, &sizes));
        EXPECT_GT(sizes.stateSizeInBytes, 0u);
        EXPECT_LT(sizes.withoutOverlapScratchSizeInBytes, sizes.withOverlapScratchSizeInBytes);
        EXPECT_GE(sizes.withoutOverlapScratchSizeInBytes, 4 * (3 + 3 * size_t(size) * size));
        OptixDenoiserSizes grown{};
        unsigned both = size + 2 * sizes.overlapWindowSizeInPixels;
        ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser_, both, both, &grown));
        EXPECT_EQ(sizes.withOverlapScratchSizeInBytes, grown.withoutOverlapScratchSizeInBytes);
    }
    const char* function = "optixDenoiserComputeMemoryResources";
    OptixDenoiserSizes sizes{};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "outputWidth",
                    optixDenoiserComputeMemoryResources(denoiser_, 0, 5, &sizes));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "outputHeight",
                    optixDenoiserComputeMemoryResources(denoiser_, 5, ~0u, &sizes));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "returnSizes",
                    optixDenoiserComputeMemoryResources(denoiser_, 5, 5, nullptr));
}

TEST_F(Denoiser, CreateRefuses) {
    OptixDenoiserOptions options{};
    OptixDenoiser made = nullptr;
    const char* function = "optixDenoiserCreate";
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "modelKind",
                    optixDenoiserCreate(context_, OptixDenoiserModelKind(0x2321), &options, &made));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "options",
                    optixDenoiserCreate(context_, kKinds[0], nullptr, &made));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "denoiser",
                    optixDenoiserCreate(context_, kKinds[0], &options, nullptr));
    EXPECT_EQ(OPTIX_ERROR_INVALID_DEVICE_CONTEXT,
              optixDenoiserCreate(nullptr, kKinds[0], &options, &made));
    EXPECT_EQ(nullptr, made);
}

TEST_F(Denoiser, UserModel) {
    std::vector<uint8_t> bytes = {'S', 'U', 'N', 'D', 'E', 'N', 'O', 'I'};
    auto put = [&](uint32_t word) {
        for (int i = 0; i < 4; ++i)
            bytes.push_back(uint8_t(word >> (8 * i)));
    };
    for (uint32_t word : {1u, 56u, 1u, 1u, 1u, 1u, 4u})
        put(word);
    for (float value : {2.0f, 0.15f, 0.25f, 0.8f}) {
        uint32_t word;
        std::memcpy(&word, &value, sizeof(word));
        put(word);
    }
    uint32_t hash = 2166136261u;
    for (uint8_t byte : bytes)
        hash = (hash ^ byte) * 16777619u;
    put(hash);
    ASSERT_OK(optixDenoiserCreateWithUserModel(context_, bytes.data(), bytes.size(), &denoiser_));
    std::fill(bytes.begin() + 20, bytes.end(), uint8_t(0)); // it was read during the call
    setup();
    Pictures pictures;
    OptixDenoiserLayer layer = pictures.layer();
    ASSERT_OK(invoke(pictures.guides(), &layer));
    EXPECT_LT(Pictures::error(pictures.output, pictures.clean),
              Pictures::error(pictures.noisy, pictures.clean) * 0.5);

    const char* function = "optixDenoiserCreateWithUserModel";
    OptixDenoiser made = nullptr;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_FILE_FORMAT, function, "checksum",
                    optixDenoiserCreateWithUserModel(context_, bytes.data(), bytes.size(), &made));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_FILE_FORMAT, function, "bytes",
                    optixDenoiserCreateWithUserModel(context_, "x", 1, &made));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, function, "userData",
                    optixDenoiserCreateWithUserModel(context_, nullptr, 56, &made));
    EXPECT_EQ(nullptr, made);
}

TEST_F(Denoiser, HandlesThatAreNone) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR);
    OptixDenoiser gone = denoiser_;
    denoiser_ = nullptr;
    ASSERT_OK(optixDenoiserDestroy(gone));
    std::vector<void*> handles = garbageHandles();
    handles.push_back(nullptr);
    handles.push_back(gone);
    handles.push_back(context_);
    Pictures pictures(4, 4);
    OptixDenoiserSizes sizes{};
    OptixDenoiserGuideLayer guides = pictures.guides();
    OptixDenoiserLayer layer = pictures.layer();
    for (void* handle : handles) {
        auto d = static_cast<OptixDenoiser>(handle);
        constexpr OptixResult kRefused = OPTIX_ERROR_INVALID_VALUE;
        EXPECT_EQ(kRefused, optixDenoiserDestroy(d));
        EXPECT_EQ(kRefused, optixDenoiserComputeMemoryResources(d, 4, 4, &sizes));
        EXPECT_EQ(kRefused, optixDenoiserSetup(d, nullptr, 4, 4, 64, 64, 64, 64));
        EXPECT_EQ(kRefused, optixDenoiserInvoke(d, nullptr, &params_, 64, 64, &guides, &layer, 1, 0,
                                                0, 64, 64));
        EXPECT_EQ(kRefused,
                  optixDenoiserComputeIntensity(d, nullptr, &pictures.noisy.image, 64, 64, 64));
        EXPECT_EQ(kRefused,
                  optixDenoiserComputeAverageColor(d, nullptr, &pictures.noisy.image, 64, 64, 64));
    }
}

TEST_F(Denoiser, ContextTakesItsDenoisersAlong) {
    OptixDeviceContext other = nullptr;
    ASSERT_OK(optixDeviceContextCreate(nullptr, nullptr, &other));
    OptixDenoiserOptions options{};
    OptixDenoiser made = nullptr;
    ASSERT_OK(optixDenoiserCreate(other, OPTIX_DENOISER_MODEL_KIND_HDR, &options, &made));
    ASSERT_OK(optixDeviceContextDestroy(other));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixDenoiserDestroy(made));
}

TEST_F(Denoiser, SetupRefuses) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR);
    setup();
    const char* function = "optixDenoiserSetup";
    auto call = [&](unsigned width, unsigned height, CUdeviceptr state, size_t stateSize,
                    CUdeviceptr scratch, size_t scratchSize) {
        return optixDenoiserSetup(denoiser_, nullptr, width, height, state, stateSize, scratch,
                                  scratchSize);
    };
    CUdeviceptr state = state_.address(), scratch = scratch_.address();
    size_t stateSize = state_.size(), scratchSize = scratch_.size();
    constexpr OptixResult kRefused = OPTIX_ERROR_INVALID_VALUE;
    EXPECT_REJECTED(kRefused, function, "inputWidth",
                    call(0, 1, state, stateSize, scratch, scratchSize));
    EXPECT_REJECTED(kRefused, function, "inputHeight",
                    call(1, 0, state, stateSize, scratch, scratchSize));
    EXPECT_REJECTED(kRefused, function, "denoiserStateSizeInBytes",
                    call(kWidth, kHeight, state, stateSize - 1, scratch, scratchSize));
    EXPECT_REJECTED(kRefused, function, "scratchSizeInBytes",
                    call(kWidth, kHeight, state, stateSize, scratch, scratchSize - 1));
    for (CUdeviceptr bad : {CUdeviceptr(0), CUdeviceptr(64), ~CUdeviceptr(0) - 4096}) {
        EXPECT_REJECTED(kRefused, function, "denoiserState",
                        call(kWidth, kHeight, bad, stateSize, scratch, scratchSize));
        EXPECT_REJECTED(kRefused, function, "scratch",
                        call(kWidth, kHeight, state, stateSize, bad, scratchSize));
    }
}

TEST_F(Denoiser, InvokeRefuses) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR);
    const char* function = "optixDenoiserInvoke";
    constexpr OptixResult kRefused = OPTIX_ERROR_INVALID_VALUE;
    Pictures pictures;
    OptixDenoiserGuideLayer guides = pictures.guides();
    OptixDenoiserLayer layer = pictures.layer();
    EXPECT_REJECTED(OPTIX_ERROR_DENOISER_NOT_INITIALIZED, function, "optixDenoiserSetup",
                    invoke(guides, &layer));
    setup();
    auto refuses = [&](const char* mention, const std::function<void()>& change) {
        guides = pictures.guides();
        layer = pictures.layer();
        params_ = {};
        change();
        EXPECT_REJECTED(kRefused, function, mention, invoke(guides, &layer));
        params_ = {};
    };
    refuses("input.data", [&] { layer.input.data = 0; });
    refuses("input.data", [&] { layer.input.data = 64; });
    refuses("output.data", [&] { layer.output.data = 0; });
    refuses("input.format", [&] { layer.input.format = OptixPixelFormat(0); });
    refuses("input.format", [&] { layer.input.format = OPTIX_PIXEL_FORMAT_FLOAT2; });
    refuses("input.width", [&] { layer.input.width = 0; });
    refuses("input.rowStride", [&] { layer.input.rowStrideInBytes = 16 * kWidth - 1; });
    refuses("input.pixelStride", [&] { layer.input.pixelStrideInBytes = 20; });
    refuses("output", [&] { layer.input.height -= 1; });
    refuses("albedo", [&] { guides.albedo.width -= 1; });
    refuses("albedo.data", [&] { guides.albedo.data = 0; });
    refuses("normal.data", [&] { guides.normal.data = 0; });
    refuses("normal.format", [&] { guides.normal.format = OPTIX_PIXEL_FORMAT_UCHAR3; });
    refuses("blendFactor", [&] { params_.blendFactor = -0.1f; });
    refuses("blendFactor", [&] { params_.blendFactor = NAN; });
    refuses("denoiseAlpha", [&] { params_.denoiseAlpha = 3; });
    refuses("hdrIntensity", [&] { params_.hdrIntensity = 64; });
    refuses("share memory", [&] {
        params_.blendFactor = 0.5f;
        layer.output = layer.input;
        layer.output.format = OPTIX_PIXEL_FORMAT_FLOAT3;
    });
    layer = pictures.layer();
    OptixDenoiserLayer two[2] = {layer, layer};
    EXPECT_REJECTED(kRefused, function, "numLayers", invoke(guides, two, 2));
    EXPECT_REJECTED(kRefused, function, "numLayers", invoke(guides, two, 0));
    EXPECT_REJECTED(kRefused, function, "inputOffset", invoke(guides, &layer, 1, 1, 0));
    EXPECT_REJECTED(kRefused, function, "inputOffset", invoke(guides, &layer, 1, 0, ~0u));
    auto raw = [&](const OptixDenoiserParams* params, const OptixDenoiserGuideLayer* guide,
                   const OptixDenoiserLayer* layers, CUdeviceptr state, size_t scratchSize) {
        return optixDenoiserInvoke(denoiser_, nullptr, params, state, state_.size(), guide, layers,
                                   1, 0, 0, scratch_.address(), scratchSize);
    };
    CUdeviceptr state = state_.address();
    size_t size = scratch_.size();
    guides = pictures.guides();
    EXPECT_REJECTED(kRefused, function, "params", raw(nullptr, &guides, &layer, state, size));
    EXPECT_REJECTED(kRefused, function, "guideLayer", raw(&params_, nullptr, &layer, state, size));
    EXPECT_REJECTED(kRefused, function, "layers", raw(&params_, &guides, nullptr, state, size));
    EXPECT_REJECTED(kRefused, function, "denoiserState",
                    raw(&params_, &guides, &layer, state + 64, size));
    EXPECT_REJECTED(kRefused, function, "scratch", raw(&params_, &guides, &layer, state, size - 1));
    // Setup for less than the call needs.
    ASSERT_OK(optixDenoiserSetup(denoiser_, nullptr, kWidth - 1, kHeight, state, state_.size(),
                                 scratch_.address(), size));
    EXPECT_REJECTED(kRefused, function, "optixDenoiserSetup", invoke(guides, &layer));

    create(OPTIX_DENOISER_MODEL_KIND_TEMPORAL);
    setup();
    refuses("flow", [&] { guides.flow.data = 0; });
    refuses("previousOutput", [&] { layer.previousOutput.data = 0; });
    refuses("normal.format", [&] {
        guides.normal = pictures.flow.image; // two channels
    });
}

TEST_F(Denoiser, GuidesThatAreNotEnabledAreIgnored) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR, false, false);
    setup();
    Pictures pictures;
    OptixDenoiserLayer layer = pictures.layer();
    OptixDenoiserGuideLayer garbage;
    std::memset(&garbage, 0xab, sizeof(garbage));
    std::memset(&layer.previousOutput, 0xcd, sizeof(layer.previousOutput));
    EXPECT_OK(invoke(garbage, &layer));
}

TEST_F(Denoiser, OverwrittenStateIsNoticed) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR);
    setup();
    wait();
    state_.fill(0);
    Pictures pictures;
    OptixDenoiserLayer layer = pictures.layer();
    pictures.output.memory.fill(0);
    log_.clear();
    invoke(pictures.guides(), &layer);
    EXPECT_TRUE(log_.hasError("overwritten", "state")) << log_.all();
    EXPECT_EQ(0.0f, pictures.output.at(3, 3)[0]);
    expectStreamError("overwritten");
}

TEST_F(Denoiser, BlendAndInPlace) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR);
    setup();
    Pictures pictures;
    OptixDenoiserLayer layer = pictures.layer();
    ASSERT_OK(invoke(pictures.guides(), &layer));
    float denoised = pictures.output.at(40, 40)[1], given = pictures.noisy.at(40, 40)[1];
    params_.blendFactor = 1;
    ASSERT_OK(invoke(pictures.guides(), &layer));
    EXPECT_NEAR(given, pictures.output.at(40, 40)[1], 1e-6f);
    params_.blendFactor = 0.25f;
    layer.output = layer.input;
    ASSERT_OK(invoke(pictures.guides(), &layer));
    EXPECT_NEAR(0.75f * denoised + 0.25f * given, pictures.noisy.at(40, 40)[1], 1e-6f);
}

TEST_F(Denoiser, EveryPixelFormat) {
    create(OPTIX_DENOISER_MODEL_KIND_HDR);
    setup();
    Pictures pictures;
    OptixDenoiserLayer layer = pictures.layer();
    ASSERT_OK(invoke(pictures.guides(), &layer));
    for (OptixPixelFormat format :
         {OPTIX_PIXEL_FORMAT_HALF3, OPTIX_PIXEL_FORMAT_HALF4, OPTIX_PIXEL_FORMAT_FLOAT3,
          OPTIX_PIXEL_FORMAT_FLOAT4, OPTIX_PIXEL_FORMAT_UCHAR3, OPTIX_PIXEL_FORMAT_UCHAR4}) {
        TestImage other(kWidth, kHeight, format, 12),
            back(kWidth, kHeight, OPTIX_PIXEL_FORMAT_FLOAT4);
        params_.blendFactor = 1; // converts
        OptixDenoiserLayer to{pictures.clean.image, {}, other.image};
        ASSERT_OK(invoke(pictures.guides(), &to));
        params_.blendFactor = 0;
        OptixDenoiserLayer from{other.image, {}, back.image};
        ASSERT_OK(invoke(pictures.guides(), &from));
        EXPECT_LT(Pictures::error(back, pictures.clean), 0.005) << format;
        if (channelsOf(format) == 3)
            EXPECT_EQ(1.0f, back.at(1, 1)[3]);
    }
}

TEST_F(Denoiser, AlphaAndLayers) {
    Pictures pictures, second;
    for (OptixDenoiserModelKind kind :
         {OPTIX_DENOISER_MODEL_KIND_HDR, OPTIX_DENOISER_MODEL_KIND_AOV,
          OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV}) {
        create(kind);
        setup();
        unsigned count = kind == OPTIX_DENOISER_MODEL_KIND_HDR ? 1 : 2;
        for (unsigned mode : {1u, 2u}) {
            params_.denoiseAlpha = mode;
            OptixDenoiserLayer layers[2] = {pictures.layer(), second.layer()};
            ASSERT_OK(invoke(pictures.guides(), layers, count));
            float low = 1, high = 0;
            for (unsigned x = 70; x < 90; ++x) {
                low = std::min(low, pictures.output.at(x, 60)[3]);
                high = std::max(high, pictures.output.at(x, 60)[3]);
            }
            EXPECT_LT(high - low, 0.6f) << kind << ' ' << mode; // 6/7 before
            if (count == 2)
                EXPECT_LT(Pictures::error(second.output, second.clean),
                          Pictures::error(second.noisy, second.clean) * 0.5);
            params_.blendFactor = 1; // alpha, too, is the input's again
            ASSERT_OK(invoke(pictures.guides(), layers, count));
            for (unsigned x = 70; x < 90; ++x)
                EXPECT_NEAR(pictures.noisy.at(x, 60)[3], pictures.output.at(x, 60)[3], 1e-6f) << x;
            params_.blendFactor = 0;
        }
    }
}

TEST_F(Denoiser, TiledEqualsWhole) {
    for (OptixDenoiserModelKind kind :
         {OPTIX_DENOISER_MODEL_KIND_HDR, OPTIX_DENOISER_MODEL_KIND_TEMPORAL}) {
        create(kind);
        Pictures pictures(300, 180);
        setup(300, 180);
        OptixDenoiserGuideLayer guides = pictures.guides();
        OptixDenoiserLayer layer = pictures.layer();
        ASSERT_OK(invoke(guides, &layer));
        TestImage tiled(300, 180, OPTIX_PIXEL_FORMAT_FLOAT4);
        layer.output = tiled.image;
        constexpr unsigned kTile = 96;
        ASSERT_OK(optixDenoiserComputeMemoryResources(denoiser_, kTile, kTile, &sizes_));
        unsigned overlap = sizes_.overlapWindowSizeInPixels, side = kTile + 2 * overlap;
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
    }
}

TEST_F(Denoiser, Statistics) {
    create(OPTIX_DENOISER_MODEL_KIND_AOV);
    TestImage image(3, 2, OPTIX_PIXEL_FORMAT_FLOAT3);
    double sum = 0, logs[3] = {};
    for (unsigned i = 0; i < 6; ++i) {
        float* pixel = image.at(i % 3, i / 3);
        for (unsigned c = 0; c < 3; ++c) {
            pixel[c] = 0.1f * float(i + 1) * float(c + 1);
            logs[c] += std::log(pixel[c]) / 6;
        }
        sum += std::log(pixel[0] * 0.212586f + pixel[1] * 0.715170f + pixel[2] * 0.072200f);
    }
    Buffer intensity(4, 8), average(12, 8), scratch(4 * (3 + 3 * 6));
    ASSERT_OK(optixDenoiserComputeIntensity(denoiser_, nullptr, &image.image, intensity.address(),
                                            scratch.address(), 4 * (2 + 6)));
    ASSERT_OK(optixDenoiserComputeAverageColor(denoiser_, nullptr, &image.image, average.address(),
                                               scratch.address(), scratch.size()));
    wait();
    EXPECT_NEAR(0.18 / std::exp(sum / 6), *intensity.as<float>(), 1e-5);
    for (unsigned c = 0; c < 3; ++c)
        EXPECT_NEAR(logs[c], average.as<float>()[c], 1e-5);

    using Function = decltype(&optixDenoiserComputeIntensity);
    struct Case {
        const char* name;
        const char* output;
        Function call;
        size_t scratch;
    };
    const Case cases[] = {
        {"optixDenoiserComputeIntensity", "outputIntensity", optixDenoiserComputeIntensity, 32},
        {"optixDenoiserComputeAverageColor", "outputAverageColor", optixDenoiserComputeAverageColor,
         84}};
    constexpr OptixResult kRefused = OPTIX_ERROR_INVALID_VALUE;
    TestImage bytes(3, 2, OPTIX_PIXEL_FORMAT_UCHAR4), two(3, 2, OPTIX_PIXEL_FORMAT_HALF2);
    for (const Case& c : cases) {
        auto call = [&](const OptixImage2D* input, CUdeviceptr output, CUdeviceptr memory,
                        size_t size) {
            return c.call(denoiser_, nullptr, input, output, memory, size);
        };
        CUdeviceptr output = average.address(), memory = scratch.address();
        EXPECT_REJECTED(kRefused, c.name, "unsigned char",
                        call(&bytes.image, output, memory, c.scratch));
        EXPECT_REJECTED(kRefused, c.name, "channels", call(&two.image, output, memory, c.scratch));
        EXPECT_REJECTED(kRefused, c.name, "inputImage", call(nullptr, output, memory, c.scratch));
        EXPECT_REJECTED(kRefused, c.name, c.output, call(&image.image, 0, memory, c.scratch));
        EXPECT_REJECTED(kRefused, c.name, "scratch",
                        call(&image.image, output, memory, c.scratch - 1));
        EXPECT_REJECTED(kRefused, c.name, "scratch", call(&image.image, output, 0, c.scratch));
    }
}

TEST_F(Denoiser, IntensityAndAverageColorAreUsed) {
    Pictures pictures, dark;
    for (unsigned y = 0; y < kHeight; ++y)
        for (unsigned x = 0; x < kWidth; ++x)
            for (unsigned c = 0; c < 3; ++c)
                dark.noisy.at(x, y)[c] *= 0x1p-24f;
    create(OPTIX_DENOISER_MODEL_KIND_AOV);
    setup();
    Buffer intensity(4, 8), average(12, 8);
    auto both = [&](Pictures& p) {
        ASSERT_OK(optixDenoiserComputeIntensity(denoiser_, nullptr, &p.noisy.image,
                                                intensity.address(), scratch_.address(),
                                                scratch_.size()));
        ASSERT_OK(optixDenoiserComputeAverageColor(denoiser_, nullptr, &p.noisy.image,
                                                   average.address(), scratch_.address(),
                                                   scratch_.size()));
        OptixDenoiserLayer layer = p.layer();
        ASSERT_OK(invoke(p.guides(), &layer));
    };
    for (bool useAverage : {false, true}) {
        params_ = {};
        (useAverage ? params_.hdrAverageColor : params_.hdrIntensity) =
            useAverage ? average.address() : intensity.address();
        both(pictures);
        both(dark);
        for (unsigned x = 0; x < kWidth; x += 7)
            EXPECT_NEAR(pictures.output.at(x, 33)[1], dark.output.at(x, 33)[1] * 0x1p24f, 1e-3f);
    }
    // Unusable scale factors are an error of the stream.
    *intensity.as<float>() = NAN;
    params_ = {};
    params_.hdrIntensity = intensity.address();
    OptixDenoiserLayer layer = pictures.layer();
    log_.clear();
    invoke(pictures.guides(), &layer);
    EXPECT_TRUE(log_.hasError("hdrIntensity", "positive")) << log_.all();
    expectStreamError("hdrIntensity");
}

TEST_F(Denoiser, TemporalMayWriteOverItsHistory) {
    create(OPTIX_DENOISER_MODEL_KIND_TEMPORAL);
    setup();
    Pictures apart, inPlace;
    TestImage history(kWidth, kHeight, OPTIX_PIXEL_FORMAT_FLOAT4);
    std::memcpy(history.memory.as<char>(), apart.clean.memory.as<char>(), history.memory.size());
    OptixDenoiserLayer layer = apart.layer();
    layer.previousOutput = apart.clean.image;
    ASSERT_OK(invoke(apart.guides(), &layer));
    OptixDenoiserLayer over = inPlace.layer();
    over.previousOutput = over.output = history.image;
    ASSERT_OK(invoke(inPlace.guides(), &over));
    EXPECT_EQ(0, std::memcmp(history.memory.as<char>(), apart.output.memory.as<char>(),
                             history.memory.size()));
}

} // namespace
} // namespace tests::api
