// SPDX-License-Identifier: Apache-2.0
// A bidirectional path tracer: a launch leaves vertices of light paths in a buffer, another
// connects camera paths to them. The lamp lights the ceiling of a room. device/bidirectional.cu.
#include "programs.h"

#include "device/bidirectional.h"

std::string_view bench_third_bidirectional_ptx();

namespace bench {
namespace {

class Bidirectional : public Renderer {
public:
    Bidirectional(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings), room_(makeRoom(settings.some(4e5, 600), 0)) {
        BidirectionalParams& p = launch_.params;
        p.room = buildMaterials(scene_, room_, memory_);
        p.lamp = {vec(-0.6f, 0.55f, -0.2f), vec(0, 0, 0.5f), vec(1.2f, 0, 0), vec(0, 1, 0), 0.6f,
                  vec(9, 8.2f, 7)};
        p.camera = makeCamera(vec(0.15f, 0.25f, -0.95f), vec(0, -0.25f, 0.4f), vec(0, 1, 0), 65,
                              settings.aspect());
        p.width = width_;
        p.height = height_;
        p.paths = std::max(64u, width_ * height_ / 4);
        p.cameraVertices = 4;
        p.lightVertices = scene_.allocate<LightVertex>(size_t(p.paths) * kLightVertices);
        p.counts = scene_.allocate<unsigned>(p.paths);
        p.image = allocatePicture();
    }
    void compile() override {
        const OptixModule module = programs_.load(bench_third_bidirectional_ptx());
        const auto light = programs_.raygen({module, "__raygen__light"});
        const auto camera = programs_.raygen({module, "__raygen__camera"});
        const auto miss = programs_.miss({module, "__miss__radiance"});
        const auto shadowMiss = programs_.miss({module, "__miss__occlusion"});
        const auto hit = programs_.hit({{module, "__closesthit__radiance"}, {}, {}});
        const auto shadowHit = programs_.hit({{module, "__closesthit__occlusion"}, {}, {}});
        pipeline_ = programs_.link({light, camera, miss, shadowMiss, hit, shadowHit}, {.trace = 2});
        std::vector<SbtRecord<BidirectionalRecord>> records;
        for (const Look& look : room_.looks) {
            const bool isMirror = look.surface == kMirror || look.surface == kGlass;
            const float3 color = look.surface == kLamp ? vec(0.7f) : look.color;
            const BidirectionalRecord r = {viewOf(memory_), color, isMirror};
            records.push_back(makeRecord(hit, r));
            records.push_back(makeRecord(shadowHit, r));
        }
        table_.setRaygen(makeRecord(light));
        cameraTable_.setRaygen(makeRecord(camera));
        for (Table* table : {&table_, &cameraTable_}) {
            table->setMisses(std::vector{makeRecord(miss), makeRecord(shadowMiss)});
            table->setHits(records);
        }
    }
    void renderFrame() override {
        launch_.run(pipeline_, table_, launch_.params.paths);
        launch_.run(pipeline_, cameraTable_, width_, height_);
    }

private:
    MaterialMesh room_;
    MeshMemory memory_;
    Table cameraTable_;
    Launch<BidirectionalParams> launch_;
};

} // namespace

JobKind bidirectionalJob() {
    return thirdJob<Bidirectional>(
        "bidirectional", "camera paths connected to the vertices of light paths in a buffer", 0.01,
        0.1);
}

} // namespace bench
