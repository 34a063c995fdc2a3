// SPDX-License-Identifier: Apache-2.0
// A radiograph of bodies inside bodies; device/xray.cu.
#include "programs.h"

#include "device/xray.h"

std::string_view bench_third_xray_ptx();

namespace bench {
namespace {

class Xray : public Renderer {
public:
    Xray(OptixDeviceContext context, const JobSettings& settings) : Renderer(context, settings) {
        const Mesh rock = makeRock(settings.some(40000, 150));
        const MeshMemory solid = uploadMesh(scene_, rock);
        Mesh tube = makeLathe({make_float2(0.25f, -1), make_float2(0.3f, -1), make_float2(0.22f, 0),
                               make_float2(0.3f, 1), make_float2(0.25f, 1), make_float2(0.17f, 0),
                               make_float2(0.25f, -1)},
                              settings.some(5000, 24));
        const MeshMemory hollow = uploadMesh(scene_, tube);
        // Each face counts once.
        const unsigned flags = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
        shapes_[0] = scene_.build(inputOf(solid, flags));
        shapes_[1] = scene_.build(inputOf(hollow, flags));
        XrayParams& p = launch_.params;
        p.patient = scene_.buildInstances(place(settings.some(400, 40)));
        p.source = vec(0, 0.4f, -9);
        p.spot = 0.05f;
        p.samples = 4;
        p.detector = {vec(-8, 5.4f, 4), vec(16, 0, 0), vec(0, -9, 0)};
        p.spectrum = vec(0.5f, 0.3f, 0.2f);
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 4;
        o.pipelineLaunchParamsVariableName = "xray";
        const OptixModule module = programs_.load(bench_third_xray_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__expose"});
        const auto miss = programs_.miss({});
        const auto hit = programs_.hit({{}, {module, "__anyhit__cross"}, {}});
        pipeline_ = programs_.link({raygen, miss, hit}, {.trace = 1, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        std::vector<SbtRecord<XrayMaterial>> records;
        for (const XrayMaterial& m : materials_)
            records.push_back(makeRecord(hit, m));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    enum Material : unsigned { kFlesh, kAir, kBone, kMarrow, kMetal, kMaterials };
    // Attenuation over that of the surrounding material.
    static constexpr XrayMaterial materials_[kMaterials] = {{{0.3f, 0.2f, 0.15f}},
                                                            {{-0.28f, -0.19f, -0.14f}},
                                                            {{1.6f, 0.9f, 0.5f}},
                                                            {{-1.1f, -0.6f, -0.3f}},
                                                            {{7, 4, 2.2f}}};

    // A body with two lungs, a spine of hollow bones, ribs of tubes, and splinters.
    std::vector<OptixInstance> place(unsigned splinters) const {
        std::vector<OptixInstance> all;
        const auto add = [&](unsigned shape, Material material, float3 at, float3 scale) {
            const float m[12] = {scale.x, 0, 0, at.x, 0, scale.y, 0, at.y, 0, 0, scale.z, at.z};
            all.push_back(instanceOf(shapes_[shape], m, unsigned(all.size()), material));
        };
        add(0, kFlesh, vec(0, 0, 0), vec(3.4f, 2.4f, 1.5f));
        add(0, kFlesh, vec(0, 2.4f, 0), vec(0.9f, 1.1f, 0.9f));
        add(0, kBone, vec(0, 2.5f, 0), vec(0.7f, 0.8f, 0.7f));
        add(0, kMarrow, vec(0, 2.5f, 0), vec(0.62f, 0.72f, 0.62f));
        for (const float side : {-1.0f, 1.0f})
            add(0, kAir, vec(1.3f * side, 0.2f, 0), vec(0.8f, 1.3f, 0.8f));
        for (unsigned i = 0; i < 14; ++i) {
            const float y = -1.8f + 0.27f * float(i);
            add(0, kBone, vec(0, y, 0.5f), vec(0.22f, 0.11f, 0.2f));
            add(0, kMarrow, vec(0, y, 0.5f), vec(0.15f, 0.07f, 0.14f));
        }
        for (unsigned i = 0; i < 9; ++i)
            add(1, kBone, vec(0, -1.1f + 0.3f * float(i), 0), vec(7.5f, 0.07f, 3.6f));
        for (unsigned i = 0; i < splinters; ++i) {
            const float3 at =
                vec(4 * randomOf(i, 0) - 2, 2.4f * randomOf(i, 1) - 1.2f, randomOf(i, 2) - 0.5f);
            const float size = 0.02f + 0.08f * randomOf(i, 4) * randomOf(i, 5);
            add(0, i % 9 ? kBone : kMetal, at, vec(size, 2 * size, size));
        }
        return all;
    }

    Launch<XrayParams> launch_;
    OptixTraversableHandle shapes_[2] = {};
};

} // namespace

JobKind xrayJob() {
    return thirdJob<Xray>("xray", "attenuation between all entries and exits of a ray", 0.002,
                          0.02);
}

} // namespace bench
