// SPDX-License-Identifier: Apache-2.0
// Light paths and camera paths in a hall, in two pipelines that share hit and miss programs;
// device/light_tracer.cu.
#include "programs.h"

#include "device/light_tracer.h"

std::string_view bench_second_light_tracer_ptx();
std::string_view bench_second_light_tracer_lamps_ptx();
std::string_view bench_second_light_tracer_eye_ptx();

namespace bench {
namespace {

class LightTracer : public Application {
public:
    LightTracer(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context) {
        const Mesh hall = makeScene(SceneKind::kInterior, settings.some(1e6, 2000));
        const MeshMemory memory = uploadMesh(scene_, hall);
        record_ = {reinterpret_cast<const float3*>(memory.vertices),
                   reinterpret_cast<const uint3*>(memory.indices)};
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        TracerParams& p = launch_.params;
        p.hall = scene_.build(inputOf(memory, flags));
        // Lamps hang below the beams and shine downwards.
        std::vector<TracerLamp> lamps;
        for (unsigned i = 0; i < 8; ++i)
            lamps.push_back({vec(-24 + 6.5f * float(i), 10.8f, i % 2 ? 2.0f : -4.0f),
                             vec(1.5f, 0, 0), vec(0, 0, 1.5f), vec(28, 26, 22)});
        p.lamps = scene_.upload(lamps);
        p.numLamps = unsigned(lamps.size());
        p.numPaths = settings.some(2e6, 4000);
        p.maxVertices = 5;
        p.width = settings.width;
        p.height = settings.height;
        p.camera = cameraOf(hall, settings);
        image_.allocate(sizeof(float4) * p.width * p.height);
        p.image = image_.as<float4>();
        p.film = scene_.allocate<float>(3 * size_t(p.width) * p.height);
    }
    void compile() override {
        const OptixModule hits = programs_.load(bench_second_light_tracer_ptx());
        const OptixModule lamps = programs_.load(bench_second_light_tracer_lamps_ptx());
        const OptixModule eye = programs_.load(bench_second_light_tracer_eye_ptx());
        const auto fromLamps = programs_.raygen({lamps, "__raygen__lamps"});
        const auto fromEye = programs_.raygen({eye, "__raygen__eye"});
        const auto outside = programs_.miss({hits, "__miss__outside"});
        const auto visible = programs_.miss({hits, "__miss__visible"});
        const auto hit = programs_.hit({{hits, "__closesthit__hall"}, {}, {}});
        lampPipeline_ = programs_.link({fromLamps, outside, visible, hit}, {});
        eyePipeline_ = programs_.link({fromEye, outside, visible, hit}, {});
        lampTable_.setRaygen(makeRecord(fromLamps));
        eyeTable_.setRaygen(makeRecord(fromEye));
        for (Table* table : {&lampTable_, &eyeTable_}) {
            table->setMisses(std::vector{makeRecord(outside), makeRecord(visible)});
            table->setHits(std::vector{makeRecord(hit, record_)});
        }
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override {
        const TracerParams& p = launch_.params;
        CUDA_CHECK(cudaMemsetAsync(p.film, 0, 3 * sizeof(float) * p.width * p.height, nullptr));
        launch_.run(lampPipeline_, lampTable_, p.numPaths);
        launch_.run(eyePipeline_, eyeTable_, p.width, p.height);
    }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    Scene scene_;
    Programs programs_;
    Table lampTable_, eyeTable_;
    Launch<TracerParams> launch_;
    OptixPipeline lampPipeline_ = nullptr, eyePipeline_ = nullptr;
    HallRecord record_ = {};
    DeviceBuffer image_;
};

} // namespace

JobKind lightTracerJob() {
    return secondJob<LightTracer>(
        "light_tracer", "light paths splatted to a film, camera paths; two pipelines", 0.01, 0.1);
}

} // namespace bench
