// SPDX-License-Identifier: Apache-2.0
// A preview: eight launches of one sample a frame, then the denoiser, if the machine has the file
// of weights that the driver's denoiser needs; device/preview.cu. The result is the mean before the
// denoiser, because denoisers differ.
#include "programs.h"

#include "device/preview.h"

#include <cstdio>
#include <filesystem>

std::string_view bench_second_preview_ptx();

namespace bench {
namespace {

constexpr unsigned kLaunches = 8;
constexpr float3 kEmission = {9, 8.5f, 7.5f};
constexpr const char* kWeights = "/usr/share/nvidia/nvoptix.bin";

// The denoiser for pictures of one size.
class PreviewDenoiser {
public:
    PreviewDenoiser(OptixDeviceContext context, unsigned width, unsigned height)
        : width_(width), height_(height) {
        const OptixDenoiserOptions options = {};
        const OptixResult result =
            optixDenoiserCreate(context, OPTIX_DENOISER_MODEL_KIND_HDR, &options, &denoiser_);
        if (result != OPTIX_SUCCESS) {
            std::printf("preview: no denoiser: %s\n", optixGetErrorName(result));
            denoiser_ = nullptr;
            return;
        }
        OptixDenoiserSizes sizes = {};
        OPTIX_CHECK(optixDenoiserComputeMemoryResources(denoiser_, width, height, &sizes));
        state_.allocate(sizes.stateSizeInBytes);
        scratch_.allocate(sizes.withoutOverlapScratchSizeInBytes);
        output_.allocate(sizeof(float4) * width * height);
        OPTIX_CHECK(optixDenoiserSetup(denoiser_, nullptr, width, height, state_.address(),
                                       state_.size(), scratch_.address(), scratch_.size()));
    }
    PreviewDenoiser(const PreviewDenoiser&) = delete;
    PreviewDenoiser& operator=(const PreviewDenoiser&) = delete;
    ~PreviewDenoiser() {
        if (denoiser_)
            optixDenoiserDestroy(denoiser_);
    }
    void run(CUdeviceptr picture) {
        if (!denoiser_)
            return;
        const auto imageOf = [&](CUdeviceptr data) {
            return OptixImage2D{data,           width_,
                                height_,        unsigned(width_ * sizeof(float4)),
                                sizeof(float4), OPTIX_PIXEL_FORMAT_FLOAT4};
        };
        OptixDenoiserLayer layer = {};
        layer.input = imageOf(picture);
        layer.output = imageOf(output_.address());
        const OptixDenoiserGuideLayer guide = {};
        const OptixDenoiserParams denoiserParams = {};
        OPTIX_CHECK(optixDenoiserInvoke(denoiser_, nullptr, &denoiserParams, state_.address(),
                                        state_.size(), &guide, &layer, 1, 0, 0, scratch_.address(),
                                        scratch_.size()));
    }

private:
    unsigned width_, height_;
    OptixDenoiser denoiser_ = nullptr;
    DeviceBuffer state_, scratch_, output_;
};

class Preview : public Application {
public:
    Preview(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context) {
        const MaterialMesh room = makeRoom(settings.some(4e5, 600), 0);
        buildRoom(room);
        PreviewParams& p = launch_.params;
        // A third of the size of other pictures: 640 x 360.
        p.width = std::max(settings.width / 3, 8u);
        p.height = std::max(settings.height / 3, 8u);
        p.maxBounces = 8;
        p.camera = makeCamera(vec(0.15f, 0.25f, -0.95f), vec(0, -0.25f, 0.4f), vec(0, 1, 0), 65,
                              settings.aspect());
        p.lamp = {vec(-0.35f, 0.97f, -0.35f),
                  vec(0.7f, 0, 0),
                  vec(0, 0, 0.7f),
                  vec(0, -1, 0),
                  0.49f,
                  kEmission};
        image_.allocate(sizeof(float4) * p.width * p.height);
        CUDA_CHECK(cudaMemset(image_.data(), 0, image_.size()));
        p.mean = image_.as<float4>();
        p.shown = scene_.allocate<uchar4>(size_t(p.width) * p.height);
        if (std::filesystem::exists(kWeights))
            denoiser_ = std::make_unique<PreviewDenoiser>(context, p.width, p.height);
    }
    void compile() override {
        const OptixModule module = programs_.load(bench_second_preview_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__sample"});
        const auto outside = programs_.miss({module, "__miss__outside"});
        const auto noShadow = programs_.miss({});
        const auto surface = programs_.hit({{module, "__closesthit__surface"}, {}, {}});
        const auto block = programs_.hit({{module, "__closesthit__block"}, {}, {}});
        pipeline_ = programs_.link({raygen, outside, noShadow, surface, block}, {.trace = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(outside), makeRecord(noShadow)});
        std::vector<SbtRecord<PreviewRecord>> records;
        for (const PreviewRecord& r : records_) {
            records.push_back(makeRecord(surface, r));
            records.push_back(makeRecord(block, r));
        }
        table_.setHits(records);
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override {
        PreviewParams& p = launch_.params;
        for (unsigned i = 0; i < kLaunches; ++i, ++p.samplesSoFar)
            launch_.run(pipeline_, table_, p.width, p.height);
        if (denoiser_)
            denoiser_->run(image_.address());
    }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    // A record for each material and ray type.
    void buildRoom(const MaterialMesh& room) {
        MeshMemory m;
        launch_.params.room = buildMaterials(scene_, room, m);
        for (const Look& look : room.looks) {
            const bool isLamp = look.surface == kLamp;
            records_.push_back({isLamp ? kEmission : vec(0.0f), look.color,
                                reinterpret_cast<const float3*>(m.vertices),
                                reinterpret_cast<const uint3*>(m.indices),
                                look.surface == kMatt ? 0.0f : 0.7f});
        }
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<PreviewParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    std::vector<PreviewRecord> records_;
    std::unique_ptr<PreviewDenoiser> denoiser_;
    DeviceBuffer image_;
};

} // namespace

JobKind previewJob() {
    return secondJob<Preview>(
        "preview", "eight small launches of a progressive path tracer, then the denoiser", 0.01,
        0.1);
}

} // namespace bench
