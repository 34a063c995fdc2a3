// SPDX-License-Identifier: Apache-2.0
// Direct light of thousands of lamps by resampling, with reservoirs of the pixel in the last frame
// and of its neighbours; device/resampling.cu.
#include "programs.h"

#include "device/resampling.h"

std::string_view bench_third_resampling_ptx();

namespace bench {
namespace {

class Resampling : public Renderer {
public:
    Resampling(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        const Mesh hall = makeScene(SceneKind::kInterior, settings.some(1.5e6, 2000));
        const MeshMemory memory = uploadMesh(scene_, hall);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        ResamplingParams& p = launch_.params;
        p.hall = scene_.build(inputOf(memory, flags));
        p.mesh = viewOf(memory);
        p.lamps = scene_.upload(hang(settings.some(6000, 64)));
        p.lampCount = settings.some(6000, 64);
        p.candidates = 24;
        p.neighbours = 5;
        p.radius = 24.0f * float(width_) / 1920;
        p.width = width_;
        p.height = height_;
        p.camera = cameraOf(hall, settings);
        const size_t pixels = size_t(width_) * height_;
        p.surfaces = scene_.allocate<PixelSurface>(pixels);
        p.found = scene_.allocate<Reservoir>(pixels);
        p.kept = scene_.allocate<Reservoir>(pixels);
        p.image = allocatePicture();
    }
    void compile() override {
        programs_.moduleOptions.optLevel = OPTIX_COMPILE_OPTIMIZATION_LEVEL_3;
        programs_.moduleOptions.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_NONE;
        programs_.options.numPayloadValues = 4;
        const OptixModule module = programs_.load(bench_third_resampling_ptx());
        const auto find = programs_.raygen({module, "__raygen__find"});
        const auto share = programs_.raygen({module, "__raygen__share"});
        const auto visible = programs_.miss({module, "__miss__visible"});
        const auto none = programs_.miss({module, "__miss__none"});
        const auto hit = programs_.hit({{module, "__closesthit__triangle"}, {}, {}});
        pipeline_ = programs_.link({find, share, none, visible, hit}, {});
        table_.setRaygen(makeRecord(find));
        shareTable_.setRaygen(makeRecord(share));
        for (Table* table : {&table_, &shareTable_}) {
            table->setMisses(std::vector{makeRecord(none), makeRecord(visible)});
            table->setHits(std::vector{makeRecord(hit)});
        }
    }
    // Two samples of each pixel: each finds reservoirs, then shares them.
    void renderFrame() override {
        for (unsigned i = 0; i < 2; ++i, ++launch_.params.sample) {
            launch_.run(pipeline_, table_, width_, height_);
            launch_.run(pipeline_, shareTable_, width_, height_);
        }
    }

private:
    // Strings of small lamps below the beams.
    static std::vector<Lamp> hang(unsigned count) {
        std::vector<Lamp> lamps;
        for (unsigned i = 0; i < count; ++i) {
            const float along = randomOf(i / 50, 0) * 56 - 28, across = float(i % 50) / 49;
            const float sag = 4 * across * (1 - across);
            const float3 at = vec(along + 0.3f * randomOf(i, 1), 10 - 5 * sag * randomOf(i / 50, 1),
                                  -11 + 22 * across);
            const float3 light = colorOf(i / 50) * (i % 17 == 0 ? 40.0f : 4.0f);
            lamps.push_back({at, vec(0.08f, 0, 0), vec(0, 0, 0.08f), light * 80.0f});
        }
        return lamps;
    }

    Table shareTable_;
    Launch<ResamplingParams> launch_;
};

} // namespace

JobKind resamplingJob() {
    return thirdJob<Resampling>("resampling", "lamps of reservoirs that launches keep and share",
                                0.01, 0.1);
}

} // namespace bench
