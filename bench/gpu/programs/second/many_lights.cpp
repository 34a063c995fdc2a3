// SPDX-License-Identifier: Apache-2.0
// Lanterns among leaves above a landscape; device/many_lights.cu.
#include "programs.h"

#include "device/many_lights.h"

#include <cmath>

std::string_view bench_second_many_lights_ptx();

namespace bench {
namespace {

constexpr unsigned kMaskSide = 128;

// A leaf: a disk with teeth, in alpha.
std::vector<unsigned char> leafTexels() {
    std::vector<unsigned char> texels = spots(3, kMaskSide);
    for (unsigned i = 0; i < kMaskSide * kMaskSide; ++i) {
        const float x = 2 * (float(i % kMaskSide) + 0.5f) / kMaskSide - 1;
        const float y = 2 * (float(i / kMaskSide) + 0.5f) / kMaskSide - 1;
        const float edge = 0.75f + 0.2f * std::sin(7 * std::atan2(y, x));
        texels[4 * size_t(i) + 3] = x * x + y * y < edge * edge ? 255 : 0;
    }
    return texels;
}

class ManyLights : public Application {
public:
    ManyLights(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), mask_(leafTexels(), kMaskSide) {
        const Mesh ground = makeScene(SceneKind::kTerrain, settings.some(8e5, 400));
        const Mesh leaves = makeLeaves(settings.some(1.2e5, 400));
        const MeshMemory memory[2] = {uploadMesh(scene_, ground), uploadMesh(scene_, leaves)};
        const auto recordOf = [](const MeshMemory& m, cudaTextureObject_t mask, float3 color) {
            return LanternRecord{reinterpret_cast<const float3*>(m.vertices),
                                 reinterpret_cast<const uint3*>(m.indices), mask, color};
        };
        records_[0] = recordOf(memory[0], 0, vec(0.5f, 0.45f, 0.4f));
        records_[1] = recordOf(memory[1], mask_.object(), vec(0.5f, 0.9f, 0.4f));
        LanternParams& p = launch_.params;
        p.handle = buildBoth(memory);
        p.width = settings.width;
        p.height = settings.height;
        p.camera = makeCamera(vec(-46, 27, -46), vec(0, 6, 0), vec(0, 1, 0), 55, settings.aspect());
        p.ambient = vec(0.03f, 0.035f, 0.05f);
        for (unsigned i = 0; i < kLanterns; ++i)
            p.lanterns[i] = {
                vec(90 * randomOf(i, 1) - 45, 12 + 12 * randomOf(i, 2), 90 * randomOf(i, 3) - 45),
                colorOf(i) * 60.0f};
        image_.allocate(sizeof(float4) * p.width * p.height);
        p.image = image_.as<float4>();
        p.colors = scene_.allocate<uchar4>(size_t(p.width) * p.height);
    }
    void compile() override {
        programs_.moduleOptions.optLevel = OPTIX_COMPILE_OPTIMIZATION_LEVEL_3;
        programs_.options.numPayloadValues = 3;
        const OptixModule module = programs_.load(bench_second_many_lights_ptx());
        const Function radiance = {module, "__closesthit__radiance"};
        const Function cutout = {module, "__anyhit__cutout"};
        const auto raygen = programs_.raygen({module, "__raygen__camera"});
        const auto background = programs_.miss({module, "__miss__background"});
        const auto shadow = programs_.miss({module, "__miss__shadow"});
        const OptixProgramGroup hits[4] = {programs_.hit({radiance, {}, {}}), programs_.hit({}),
                                           programs_.hit({radiance, cutout, {}}),
                                           programs_.hit({{}, cutout, {}})};
        pipeline_ = programs_.link({raygen, background, shadow, hits[0], hits[1], hits[2], hits[3]},
                                   {.trace = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(background), makeRecord(shadow)});
        std::vector<SbtRecord<LanternRecord>> records;
        for (unsigned i = 0; i < 4; ++i)
            records.push_back(makeRecord(hits[i], records_[i / 2]));
        table_.setHits(records);
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override {
        launch_.run(pipeline_, table_, launch_.params.width, launch_.params.height);
    }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    // One structure of two inputs, of which one needs no any-hit programs.
    OptixTraversableHandle buildBoth(const MeshMemory (&memory)[2]) {
        const unsigned flags[2] = {OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT, OPTIX_GEOMETRY_FLAG_NONE};
        const OptixBuildInput inputs[2] = {inputOf(memory[0], flags[0]),
                                           inputOf(memory[1], flags[1])};
        OptixAccelBuildOptions options = {};
        options.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
        options.operation = OPTIX_BUILD_OPERATION_BUILD;
        OptixAccelBufferSizes sizes = {};
        OPTIX_CHECK(optixAccelComputeMemoryUsage(scene_.context(), &options, inputs, 2, &sizes));
        const DeviceBuffer temporary(sizes.tempSizeInBytes);
        structure_.allocate(sizes.outputSizeInBytes);
        OptixTraversableHandle handle = 0;
        OPTIX_CHECK(optixAccelBuild(scene_.context(), nullptr, &options, inputs, 2,
                                    temporary.address(), temporary.size(), structure_.address(),
                                    structure_.size(), &handle, nullptr, 0));
        CUDA_CHECK(cudaDeviceSynchronize());
        return handle;
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<LanternParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    Texture mask_;
    LanternRecord records_[2] = {};
    DeviceBuffer structure_, image_;
};

} // namespace

JobKind manyLightsJob() {
    return secondJob<ManyLights>(
        "many_lights", "32 shadow rays from a closest-hit program, alpha on a part", 0.002, 0.02);
}

} // namespace bench
