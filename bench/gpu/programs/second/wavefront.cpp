// SPDX-License-Identifier: Apache-2.0
// A path tracer whose rays and hits are in queues: launches that only trace, CUDA kernels that
// shade, and counters that the host reads after each bounce; device/wavefront.cu.
#include "programs.h"

#include "device/wavefront.h"

std::string_view bench_second_wavefront_ptx();
std::string_view bench_second_wavefront_kernels_ptx();

namespace bench {
namespace {

constexpr unsigned kBounces = 6;

class Wavefront : public Application {
public:
    Wavefront(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context) {
        const Mesh mesh = makeScene(SceneKind::kInterior, settings.some(1.5e6, 5000));
        const MeshMemory memory = uploadMesh(scene_, mesh);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        launch_.params.handle = scene_.build(inputOf(memory, flags));
        const size_t pixels = size_t(settings.width) * settings.height;
        for (unsigned i = 0; i < 2; ++i) {
            rays_[i] = scene_.allocate<QueuedRay>(pixels);
            paths_[i] = scene_.allocate<QueuedPath>(pixels);
        }
        shade_.hits = launch_.params.hits = scene_.allocate<QueuedHit>(pixels);
        shade_.shadowRays = scene_.allocate<QueuedRay>(pixels);
        shade_.lights = scene_.allocate<QueuedLight>(pixels);
        launch_.params.shadowRays = shade_.shadowRays;
        launch_.params.lights = shade_.lights;
        shade_.counters = scene_.allocate<WaveCounters>(1);
        shade_.vertices = reinterpret_cast<const float3*>(memory.vertices);
        shade_.indices = reinterpret_cast<const uint3*>(memory.indices);
        shade_.camera = cameraOf(mesh, settings);
        for (unsigned i = 0; i < kWaveLamps; ++i)
            shade_.lamps[i] =
                make_float4(6.5f * float(i) - 24, 8 + float(i % 3), i % 2 ? 4.0f : -3.0f, 40);
        shade_.width = settings.width;
        shade_.height = settings.height;
        image_.allocate(sizeof(float4) * pixels);
        shade_.image = launch_.params.image = image_.as<float4>();
    }
    void compile() override {
        programs_.options.numPayloadValues = 4;
        const OptixModule module = programs_.load(bench_second_wavefront_ptx());
        const auto closest = programs_.raygen({module, "__raygen__closest"});
        const auto shadow = programs_.raygen({module, "__raygen__shadow"});
        const auto closestMiss = programs_.miss({module, "__miss__closest"});
        const auto shadowMiss = programs_.miss({module, "__miss__shadow"});
        const auto hit = programs_.hit({{module, "__closesthit__store"}, {}, {}});
        pipeline_ = programs_.link({closest, shadow, closestMiss, shadowMiss, hit}, {});
        closestTable_.setRaygen(makeRecord(closest));
        shadowTable_.setRaygen(makeRecord(shadow));
        for (Table* table : {&closestTable_, &shadowTable_}) {
            table->setMisses(std::vector{makeRecord(closestMiss), makeRecord(shadowMiss)});
            table->setHits(std::vector{makeRecord(hit)});
        }
        kernels_ = std::make_unique<Kernels>(bench_second_wavefront_kernels_ptx());
    }
    double compileTime() const override { return programs_.compileTime(); }

    void renderFrame() override {
        ShadeParams& s = shade_;
        WaveCounters counters = {s.width * s.height, 0};
        s.nextRays = rays_[0];
        s.nextPaths = paths_[0];
        s.count = counters.paths;
        kernels_->run("makeCameraRays", s.count, s);
        for (s.bounce = 0; s.bounce < kBounces && counters.paths > 0; ++s.bounce) {
            const unsigned now = s.bounce % 2;
            s.count = counters.paths;
            launch_.params.rays = s.rays = rays_[now];
            s.paths = paths_[now];
            s.nextRays = rays_[1 - now];
            s.nextPaths = paths_[1 - now];
            CUDA_CHECK(cudaMemsetAsync(s.counters, 0, sizeof(WaveCounters), nullptr));
            launch_.run(pipeline_, closestTable_, s.count);
            kernels_->run("shadeHits", s.count, s);
            CUDA_CHECK(cudaMemcpy(&counters, s.counters, sizeof(counters), cudaMemcpyDeviceToHost));
            if (counters.shadowRays > 0)
                launch_.run(pipeline_, shadowTable_, counters.shadowRays);
        }
    }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    Scene scene_;
    Programs programs_;
    Table closestTable_, shadowTable_;
    Launch<WaveParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    std::unique_ptr<Kernels> kernels_;
    ShadeParams shade_ = {};
    QueuedRay* rays_[2] = {};
    QueuedPath* paths_[2] = {};
    DeviceBuffer image_;
};

} // namespace

JobKind wavefrontJob() {
    return secondJob<Wavefront>(
        "wavefront", "queues of rays: launches that only trace, kernels that shade", 0.01, 0.1);
}

} // namespace bench
