// SPDX-License-Identifier: Apache-2.0
// Irradiance probes of a game: small launches of three dimensions update a grid of probes, then a
// picture reads it; device/probes.cu.
#include "programs.h"

#include "device/probes.h"

std::string_view bench_third_probes_ptx();

namespace bench {
namespace {

class Probes : public Renderer {
public:
    Probes(OptixDeviceContext context, const JobSettings& settings) : Renderer(context, settings) {
        const Mesh hall = makeScene(SceneKind::kInterior, settings.some(1e6, 2000));
        const MeshMemory memory = uploadMesh(scene_, hall);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        record_ = {viewOf(memory), scene_.upload(smoothNormals(hall)), vec(0.7f, 0.65f, 0.6f)};
        ProbeParams& p = launch_.params;
        p.hall = scene_.build(inputOf(memory, flags));
        p.counts = make_uint3(24, 6, 10);
        p.low = vec(-29, 0.5f, -11);
        p.high = vec(29, 10.8f, 11);
        const size_t probes = size_t(p.counts.x) * p.counts.y * p.counts.z;
        p.radiance = scene_.allocate<float3>(probes * kProbeRays);
        for (auto*& harmonics : harmonics_)
            harmonics = scene_.allocate<float3>(probes * kHarmonics);
        for (unsigned i = 0; i < kLamps; ++i)
            p.lamps[i] = {vec(-25 + 10 * float(i), 8.5f, i % 2 ? 8.5f : -8.5f), colorOf(i) * 130};
        p.camera = cameraOf(hall, settings);
        p.image = allocatePicture();
    }
    void compile() override {
        programs_.options.numPayloadValues = 6;
        programs_.options.pipelineLaunchParamsVariableName = "g_params";
        const OptixModule module = programs_.load(bench_third_probes_ptx());
        const OptixProgramGroup raygens[3] = {programs_.raygen({module, "__raygen__gather"}),
                                              programs_.raygen({module, "__raygen__blend"}),
                                              programs_.raygen({module, "__raygen__view"})};
        const auto miss = programs_.miss({module, "__miss__all"});
        const auto hit = programs_.hit({{module, "__closesthit__hall"}, {}, {}});
        pipeline_ = programs_.link({raygens[0], raygens[1], raygens[2], miss, hit}, {});
        for (unsigned i = 0; i < 3; ++i) {
            tables_[i].setRaygen(makeRecord(raygens[i]));
            tables_[i].setMisses(std::vector{makeRecord(miss)});
            tables_[i].setHits(std::vector{makeRecord(hit, record_)});
        }
    }
    // Eight updates of all probes, each from the last, in slices of the grid.
    void renderFrame() override {
        ProbeParams& p = launch_.params;
        for (unsigned update = 0; update < 8; ++update, ++p.update) {
            p.before = harmonics_[update % 2];
            p.after = harmonics_[1 - update % 2];
            for (p.slice = 0; p.slice < p.counts.z; ++p.slice)
                launch_.run(pipeline_, tables_[0], kProbeRays, p.counts.x, p.counts.y);
            launch_.run(pipeline_, tables_[1], p.counts.x, p.counts.y, p.counts.z);
        }
        launch_.run(pipeline_, tables_[2], width_, height_);
    }

private:
    Table tables_[3];
    Launch<ProbeParams> launch_;
    ProbeRecord record_ = {};
    float3* harmonics_[2] = {};
};

} // namespace

JobKind probesJob() {
    return thirdJob<Probes>("probes",
                            "88 small launches of a grid of irradiance probes, then the picture",
                            0.002, 0.02);
}

} // namespace bench
