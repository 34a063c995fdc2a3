// SPDX-License-Identifier: Apache-2.0
// The denoiser through each generation of its interface: images as one array and a model set later
// (7.0 to 7.2), guides and layers (7.3 on), sizes and first frames (7.5 on). All give equal results
// for equal images, bit for bit.
#include "scene.h"

#include <cmath>
#include <random>

namespace tests::abi {
namespace {

constexpr int kLdr = 0x2322, kHdr = 0x2323, kAov = 0x2324, kTemporal = 0x2325;
constexpr int kColor = 0x2301, kColorAlbedo = 0x2302, kColorAlbedoNormal = 0x2303;
constexpr int kFloat3 = 0x2203, kFloat2 = 0x2208;
constexpr unsigned kWidth = 40, kHeight = 30;

// A noisy image and its guides; the same in all tests.
struct Pictures {
    std::vector<float> color, albedo, normal, extra;
    Pictures() {
        std::mt19937 random(11);
        std::exponential_distribution<float> noise(1.0f);
        for (unsigned y = 0; y < kHeight; ++y)
            for (unsigned x = 0; x < kWidth; ++x) {
                const bool left = x < kWidth / 2;
                for (int c = 0; c < 3; ++c) {
                    color.push_back((left ? 0.8f : 0.2f) * noise(random));
                    albedo.push_back(left ? 0.8f : 0.2f);
                    normal.push_back(c == 2 ? 1.0f : 0.0f);
                    extra.push_back(0.5f * noise(random));
                }
            }
    }
};

Image2D image(const Memory& memory, int format = kFloat3) {
    const unsigned pixel = format == kFloat2 ? 8 : 12;
    return {memory.address(), kWidth, kHeight, kWidth * pixel, 0, format};
}

// A denoiser of release R, made and set up.
template <class R>
class Denoiser {
public:
    using Params = typename R::DenoiserParams;

    explicit Denoiser(int kind, bool albedo = true, bool normal = true)
        : kind_(kind), albedo_(albedo), normal_(normal) {
        Guarded<typename R::DenoiserOptions> options;
        if constexpr (R::kAbi < 47) {
            set(options->inputKind, normal ? kColorAlbedoNormal : albedo ? kColorAlbedo : kColor);
            if constexpr (R::kAbi < 36)
                set(options->pixelFormat, kFloat3);
            client_.expect(client_.call("DenoiserCreate", client_.context(), (const void*)options,
                                        &denoiser_));
            client_.expect(
                client_.call("DenoiserSetModel", denoiser_, kind, (void*)nullptr, size_t(0)));
        } else {
            set(options->guideAlbedo, unsigned(albedo));
            set(options->guideNormal, unsigned(normal));
            client_.expect(client_.call("DenoiserCreate", client_.context(), kind,
                                        (const void*)options, &denoiser_));
        }
        setUp();
    }
    ~Denoiser() {
        client_.wait();
        client_.expect(client_.call("DenoiserDestroy", denoiser_));
    }

    typename R::DenoiserSizes& sizes() { return *sizes_.get(); }
    Client<R>& client() { return client_; }
    void* handle() const { return denoiser_; }
    Params& params() { return *params_.get(); }

    // Denoises the pictures; `layers` counts the colours and the extra image.
    std::vector<float> run(unsigned layers = 1) {
        Memory output(color_.size()), extraOutput(color_.size());
        client_.expect(invoke(image(output), image(extraOutput), layers));
        client_.wait();
        Memory& wanted = layers == 1 ? output : extraOutput;
        return std::vector<float>(wanted.as<float>(), wanted.as<float>() + color_.size() / 4);
    }

    int invoke(const Image2D& output, const Image2D& extraOutput, unsigned layers) {
        if constexpr (R::kAbi < 47) {
            std::vector<Image2D> list = {image(color_)};
            if (albedo_)
                list.push_back(image(albedoImage_));
            if (normal_)
                list.push_back(image(normalImage_));
            if (layers == 2)
                list.push_back(image(extra_));
            return invokeList(list, {output, extraOutput});
        } else {
            Guarded<typename R::GuideLayer> guides;
            guides->albedo = image(albedoImage_);
            guides->normal = image(normalImage_);
            guides->flow = image(flow_, kFloat2);
            Guarded<DenoiserLayer> list(layers);
            list[0] = {image(color_), previous_, output};
            if (layers == 2)
                list[1] = {image(extra_), previous_, extraOutput};
            return client_.call("DenoiserInvoke", denoiser_, (void*)nullptr, (const void*)params_,
                                state_->address(), state_->size(), (const void*)guides,
                                (const void*)list, layers, 0u, 0u, scratch_->address(),
                                scratch_->size());
        }
    }
    // The form until 7.2: one array of inputs.
    int invokeList(const std::vector<Image2D>& inputs, const std::vector<Image2D>& outputs) {
        Guarded<Image2D> in(inputs.size());
        for (size_t i = 0; i < inputs.size(); ++i)
            in[i] = inputs[i];
        return client_.call("DenoiserInvoke", denoiser_, (void*)nullptr, (const void*)params_,
                            state_->address(), state_->size(), (const void*)in,
                            unsigned(inputs.size()), 0u, 0u, (const void*)outputs.data(),
                            scratch_->address(), scratch_->size());
    }
    void usePrevious(const Image2D& previous) { previous_ = previous; }
    Image2D colorImage() const { return image(color_); }
    Memory& scratch() { return *scratch_; }

private:
    void setUp() {
        client_.expect(client_.call("DenoiserComputeMemoryResources", denoiser_, kWidth, kHeight,
                                    (void*)sizes_.get()));
        state_ = std::make_unique<Memory>(sizes_->state);
        scratch_ = std::make_unique<Memory>(sizes_->withoutOverlap);
        client_.expect(client_.call("DenoiserSetup", denoiser_, (void*)nullptr, kWidth, kHeight,
                                    state_->address(), state_->size(), scratch_->address(),
                                    scratch_->size()));
        set(params_->denoiseAlpha, 0u);
        set(params_->hdrIntensity, 0);
        set(params_->blendFactor, 0.0f);
        if constexpr (R::kAbi >= 41)
            set(params_->hdrAverageColor, 0);
        if constexpr (R::kAbi >= 60)
            set(params_->temporalModeUsePreviousLayers, 1u);
    }

    Client<R> client_;
    Pictures pictures_;
    Memory color_{pictures_.color}, albedoImage_{pictures_.albedo}, normalImage_{pictures_.normal};
    Memory extra_{pictures_.extra}, flow_{size_t(kWidth) * kHeight * 8};
    int kind_;
    bool albedo_, normal_;
    void* denoiser_ = nullptr;
    Guarded<typename R::DenoiserSizes> sizes_;
    Guarded<Params> params_;
    std::unique_ptr<Memory> state_, scratch_;
    Image2D previous_{};
};

double distance(const std::vector<float>& a, float left, float right) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        const double want = i / 3 % kWidth < kWidth / 2 ? left : right;
        sum += (a[i] - want) * (a[i] - want);
    }
    return std::sqrt(sum / double(a.size()));
}

template <class R>
class DenoiserOf : public testing::Test {};
using Releases =
    testing::Types<Release70, Release71, Release72, Release73, Release74, Release75, Release76>;
TYPED_TEST_SUITE(DenoiserOf, Releases);

TYPED_TEST(DenoiserOf, SameResult) {
    static const std::vector<float> expected = Denoiser<Release74>(kHdr).run();
    EXPECT_LT(distance(expected, 0.8f, 0.2f), 0.5 * distance(Pictures().color, 0.8f, 0.2f));
    EXPECT_EQ(expected, Denoiser<TypeParam>(kHdr).run());
}

TYPED_TEST(DenoiserOf, SameResultWithoutGuides) {
    static const std::vector<float> expected = Denoiser<Release74>(kLdr, false, false).run();
    EXPECT_EQ(expected, Denoiser<TypeParam>(kLdr, false, false).run());
    static const std::vector<float> albedo = Denoiser<Release74>(kLdr, true, false).run();
    EXPECT_EQ(albedo, Denoiser<TypeParam>(kLdr, true, false).run());
    EXPECT_NE(expected, albedo);
}

TYPED_TEST(DenoiserOf, LayersSince72) {
    if constexpr (TypeParam::kAbi < 41) {
        Client<TypeParam> client;
        Guarded<typename TypeParam::DenoiserOptions> options;
        set(options->inputKind, kColor);
        void* denoiser = nullptr;
        client.expect(
            client.call("DenoiserCreate", client.context(), (const void*)options, &denoiser));
        EXPECT_EQ(kInvalidValue,
                  client.call("DenoiserSetModel", denoiser, kAov, (void*)nullptr, size_t(0)));
    } else {
        static const std::vector<float> expected = Denoiser<Release74>(kAov).run(2);
        EXPECT_EQ(expected, Denoiser<TypeParam>(kAov).run(2));
        EXPECT_NE(expected, Denoiser<TypeParam>(kAov).run(1));
    }
}

TYPED_TEST(DenoiserOf, Sizes) {
    Denoiser<TypeParam> denoiser(kHdr);
    auto& sizes = denoiser.sizes();
    EXPECT_LE(sizes.withoutOverlap, sizes.withOverlap);
    if constexpr (TypeParam::kAbi < 60) {
        EXPECT_EQ(0xA5A5A5A5u, sizes.padding28) << "what is behind the last member is not written";
    } else {
        EXPECT_GE(sizes.averageColor, 4u * (3 + 3 * kWidth * kHeight));
        EXPECT_GE(sizes.intensity, 4u * (2 + kWidth * kHeight));
        EXPECT_EQ(0u, sizes.internalGuideLayerPixelSize);
        EXPECT_EQ(0xA5A5A5A5u, sizes.padding52);
    }
}

TYPED_TEST(DenoiserOf, Intensity) {
    Denoiser<TypeParam> denoiser(kHdr);
    Memory intensity(4), scratch(4 * (2 + kWidth * kHeight));
    const Image2D input = denoiser.colorImage();
    Client<TypeParam>& client = denoiser.client();
    client.expect(client.call("DenoiserComputeIntensity", denoiser.handle(), (void*)nullptr,
                              (const void*)&input, intensity.address(), scratch.address(),
                              scratch.size()));
    client.wait();
    EXPECT_GT(*intensity.template as<float>(), 0.1f);
    set(denoiser.params().hdrIntensity, intensity.address());
    EXPECT_EQ(Pictures().color.size(), denoiser.run().size());
}

TYPED_TEST(DenoiserOf, ModelBeforeUse) {
    if constexpr (TypeParam::kAbi < 47) {
        Client<TypeParam> client;
        Guarded<typename TypeParam::DenoiserOptions> options;
        set(options->inputKind, kColorAlbedo);
        void* denoiser = nullptr;
        const auto create = [&] {
            return client.call("DenoiserCreate", client.context(), (const void*)options, &denoiser);
        };
        for (int bad : {0, 0x2300, 0x2304}) {
            set(options->inputKind, bad);
            EXPECT_EQ(kInvalidValue, create()) << bad;
            EXPECT_EQ(nullptr, denoiser);
        }
        set(options->inputKind, kColorAlbedo);
        client.expect(create());
        constexpr int kModelNotSet = 7300;
        typename TypeParam::DenoiserSizes sizes{};
        EXPECT_EQ(kModelNotSet, client.call("DenoiserComputeMemoryResources", denoiser, kWidth,
                                            kHeight, (void*)&sizes));
        Memory memory(1 << 20);
        EXPECT_EQ(kModelNotSet,
                  client.call("DenoiserSetup", denoiser, (void*)nullptr, kWidth, kHeight,
                              memory.address(), memory.size(), memory.address(), memory.size()));
        const auto setModel = [&](int kind, const void* data, size_t size) {
            return client.call("DenoiserSetModel", denoiser, kind, data, size);
        };
        EXPECT_EQ(kInvalidValue, setModel(0x2320, nullptr, 0));
        EXPECT_EQ(kInvalidValue, setModel(kTemporal, nullptr, 0)) << "came with 7.3";
        EXPECT_EQ(kInvalidValue, setModel(0x2321, nullptr, 0)) << "user model without data";
        EXPECT_EQ(7005, setModel(0x2321, "nonsense", 8)) << "not a model";
        EXPECT_EQ(kSuccess, setModel(kHdr, nullptr, 0));
        client.expect(client.call("DenoiserDestroy", denoiser));
    }
}

TYPED_TEST(DenoiserOf, WrongImageCounts) {
    if constexpr (TypeParam::kAbi < 47) {
        Denoiser<TypeParam> denoiser(kHdr);
        Memory output(size_t(kWidth) * kHeight * 12);
        const Image2D one = denoiser.colorImage();
        const std::vector<Image2D> outputs = {image(output)};
        EXPECT_EQ(kInvalidValue, denoiser.invokeList({}, outputs));
        EXPECT_EQ(kInvalidValue, denoiser.invokeList({one, one}, outputs)) << "no normals";
        EXPECT_EQ(kInvalidValue, denoiser.invokeList({one, one, one, one}, outputs)) << "no AOVs";
    }
}

TYPED_TEST(DenoiserOf, Kinds) {
    if constexpr (TypeParam::kAbi >= 47) {
        Client<TypeParam> client;
        Guarded<typename TypeParam::DenoiserOptions> options;
        set(options->guideAlbedo, 0u);
        set(options->guideNormal, 0u);
        const auto create = [&](int kind) {
            void* denoiser = nullptr;
            return client.call("DenoiserCreate", client.context(), kind, (const void*)options,
                               &denoiser);
        };
        for (int kind : {kLdr, kHdr, kAov, kTemporal})
            EXPECT_EQ(kSuccess, create(kind));
        EXPECT_EQ(kInvalidValue, create(0x2321)) << "user models have a function of their own";
        for (int upscaling : {0x2327, 0x2328})
            EXPECT_EQ(TypeParam::kAbi < 60 ? kInvalidValue : kSuccess, create(upscaling))
                << "came with 7.5";
        EXPECT_EQ(kInvalidValue, create(0x2329));
    }
}

// From 7.5 on, an option marks the first frame of a sequence.
TYPED_TEST(DenoiserOf, FirstFrames) {
    if constexpr (TypeParam::kAbi >= 47) {
        Denoiser<TypeParam> denoiser(kTemporal);
        Memory output(size_t(kWidth) * kHeight * 12);
        EXPECT_EQ(kInvalidValue, denoiser.invoke(image(output), {}, 1)) << "no previous image";
        denoiser.usePrevious(denoiser.colorImage());
        const std::vector<float> withPrevious = denoiser.run();
        if constexpr (TypeParam::kAbi >= 60) {
            denoiser.usePrevious({});
            set(denoiser.params().temporalModeUsePreviousLayers, 0u);
            EXPECT_NE(withPrevious, denoiser.run());
        }
    }
}

} // namespace
} // namespace tests::abi
