// SPDX-License-Identifier: Apache-2.0
// A room with derivatives of its light, in many payload values; device/gradients.cu.
#include "programs.h"

#include "device/gradients.h"

std::string_view bench_fourth_gradients_ptx();

namespace bench {
namespace {

class Gradients : public Renderer {
public:
    Gradients(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings), mesh_(makeRoom(settings.some(8e5, 3000), 0)) {
        GradientParams& p = launch_.params;
        p.room = buildMaterials(scene_, mesh_, memory_);
        p.camera = makeCamera(vec(0.15f, 0.25f, -0.95f), vec(0, -0.25f, 0.4f), vec(0, 1, 0), 65,
                              settings.aspect());
        const float unknowns[kUnknowns] = {0.1f, 0.6f, -0.5f, 3.5f, 1, 0.95f};
        std::copy(std::begin(unknowns), std::end(unknowns), p.unknowns);
        p.samples = 2;
        p.maxDepth = 3;
        p.image = allocatePicture();
    }
    void compile() override {
        programs_.options.numPayloadValues = 23;
        const OptixModule module = programs_.load(bench_fourth_gradients_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__gradients"});
        const auto dark = programs_.miss({module, "__miss__dark"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto hit = programs_.hit({{module, "__closesthit__wall"}, {}, {}});
        pipeline_ = programs_.link({raygen, dark, open, hit}, {.trace = 5});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(dark), makeRecord(open)});
        std::vector<SbtRecord<GradientRecord>> records;
        for (const Look& look : mesh_.looks) {
            const bool isMirror =
                look.surface == kMirror || look.surface == kGlossy || look.surface == kGlass;
            records.push_back(makeRecord(
                hit, GradientRecord{viewOf(memory_), look.color, isMirror ? 0.7f : 0.0f}));
        }
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    MaterialMesh mesh_;
    MeshMemory memory_;
    Launch<GradientParams> launch_;
};

} // namespace

JobKind gradientsJob() {
    return fourthJob<Gradients>(
        "gradients", "light with derivatives by six unknowns in 23 payload values", 0.01, 0.1);
}

} // namespace bench
