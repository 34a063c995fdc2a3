// SPDX-License-Identifier: Apache-2.0
// A court of paper lanterns: ellipsoids, hyperboloids, cones and tubes with patterns of holes,
// which are custom primitives with any-hit programs; device/latticework.cu.
#include "programs.h"

#include "device/latticework.h"

std::string_view bench_fifth_latticework_ptx();

namespace bench {
namespace {

constexpr unsigned kLanterns = 8;

using Shells = std::vector<LatticeShell>;

LatticeShell makeBall(float3 at, float3 axes, unsigned pattern, float3 color) {
    return {at, axes, 1, 1, -1, 1, pattern, 18, 7, color};
}
LatticeShell makeTube(float3 at, float radius, float half, unsigned pattern, float3 color) {
    return {at, vec(radius, half, radius), 0, 1, -1, 1, pattern, 14, 4, color};
}
LatticeShell makeWaist(float3 at, float radius, float half, unsigned pattern, float3 color) {
    return {at, vec(radius, half, radius), -0.75f, 0.25f, -1, 1, pattern, 16, 5, color};
}
// With its tip upwards.
LatticeShell makeCone(float3 tip, float radius, float height, unsigned pattern, float3 color) {
    return {tip, vec(radius, height, radius), -1, 0, -1, 0, pattern, 16, 6, color};
}

// Balls in balls, tubes around waists, roofs of cones, and small ones around.
Shells makeLantern(unsigned kind) {
    const auto color = [&](unsigned i) { return colorOf(31 * kind + i) * 0.9f; };
    const unsigned pattern = kRoundHoles + kind % 4, other = kRoundHoles + (kind + 1) % 4;
    Shells shells;
    if (kind % 2 == 0) {
        shells = {makeBall(vec(0, 1.2f, 0), vec(0.95f, 0.8f, 0.95f), pattern, color(0)),
                  makeBall(vec(0, 1.2f, 0), vec(0.65f, 0.55f, 0.65f), other, color(1)),
                  makeBall(vec(0, 1.2f, 0), vec(0.3f), kSolidWall, color(2)),
                  makeWaist(vec(0, 0.35f, 0), 0.45f, 0.35f, other, color(3))};
    } else {
        shells = {makeTube(vec(0, 0.9f, 0), 0.7f, 0.8f, pattern, color(0)),
                  makeWaist(vec(0, 0.9f, 0), 0.6f, 0.75f, other, color(1)),
                  makeBall(vec(0, 0.9f, 0), vec(0.22f, 0.5f, 0.22f), kSolidWall, color(2))};
    }
    shells.push_back(makeCone(vec(0, 2.5f, 0), 0.9f, 0.6f, other, color(4)));
    const unsigned around = 12 + 2 * kind;
    for (unsigned i = 0; i < around; ++i) {
        const float2 c = circlePoint(float(i) / float(around));
        const float y = 0.25f + 1.6f * randomOf(i, kind);
        shells.push_back(makeBall(vec(1.05f * c.x, y, 1.05f * c.y), vec(0.13f, 0.18f, 0.13f),
                                  i % 3 ? pattern : kSolidWall, color(5 + i % 3)));
        shells.push_back(
            makeCone(vec(1.05f * c.x, y + 0.3f, 1.05f * c.y), 0.14f, 0.14f, kSolidWall, color(8)));
    }
    return shells;
}
// Each is within a radius of one unit.
OptixAabb boundsOf(const LatticeShell& s) {
    const float3 low = s.at + vec(-1, s.low, -1) * s.axes, high = s.at + vec(1, s.high, 1) * s.axes;
    return {low.x, low.y, low.z, high.x, high.y, high.z};
}

class Latticework : public Renderer {
public:
    Latticework(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        for (unsigned i = 0; i < kLanterns; ++i) {
            const Shells shells = makeLantern(i);
            std::vector<OptixAabb> boxes;
            for (const LatticeShell& s : shells)
                boxes.push_back(boundsOf(s));
            lanterns_[i] = scene_.buildBoxes(boxes, OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL);
            records_[i].shells = scene_.upload(shells);
        }
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const MeshMemory floor = uploadMesh(scene_, makeBox(vec(-300, -1, -300), vec(300, 0, 300)));
        floor_ = scene_.build(inputOf(floor, flags));
        LatticeParams& p = launch_.params;
        const auto across = unsigned(std::sqrt(settings.some(3000, 16)));
        p.court = scene_.buildInstances(place(across));
        p.camera =
            makeCamera(vec(-4, 5.5f, -11), vec(0, 0.3f, -2), vec(0, 1, 0), 45, settings.aspect());
        p.sun = normalize(vec(-0.7f, 0.6f, 0.25f));
        p.lamp = vec(3, 5.5f, -3);
        p.softness = 0.03f;
        p.samples = 2;
        p.sunRays = 2;
        p.maxLayers = 5;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        o.numPayloadValues = 7;
        const OptixModule module = programs_.load(bench_fifth_latticework_ptx());
        const Function walls = {module, "__intersection__shell"};
        const auto raygen = programs_.raygen({module, "__raygen__court"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto lit = programs_.miss({});
        const auto shell =
            programs_.hit({{module, "__closesthit__shell"}, {module, "__anyhit__cut"}, walls});
        const auto shadow = programs_.hit({{}, {module, "__anyhit__count"}, walls});
        const auto floor = programs_.hit({{module, "__closesthit__floor"}, {}, {}});
        const auto none = programs_.hit({});
        pipeline_ = programs_.link({raygen, sky, lit, shell, shadow, floor, none},
                                   {.trace = 1, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(lit)});
        std::vector<SbtRecord<LatticeRecord>> records;
        for (const LatticeRecord& r : records_) {
            records.push_back(makeRecord(r.shells ? shell : floor, r));
            records.push_back(makeRecord(r.shells ? shadow : none, r));
        }
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    // Shadow rays do not see the floor.
    std::vector<OptixInstance> place(unsigned across) const {
        std::vector<OptixInstance> all = {instanceOf(floor_, kIdentity, 0, 2 * kLanterns)};
        all[0].visibilityMask = 2;
        for (unsigned i = 1; i <= across * across; ++i) {
            const float3 at = vec(3.2f * (float(i % across) + 0.3f * randomOf(i, 0)), 0,
                                  3.2f * (float(i / across) + 0.3f * randomOf(i, 1))) -
                              vec(1.6f, 0, 1.6f) * float(across);
            const auto kind = unsigned(kLanterns * randomOf(i, 2));
            const Placement to = placed(at, 0.8f + 0.5f * randomOf(i, 3), randomOf(i, 4));
            all.push_back(instanceOf(lanterns_[kind], to.matrix, i, 2 * kind));
            all.back().visibilityMask = 1;
        }
        return all;
    }

    OptixTraversableHandle lanterns_[kLanterns] = {}, floor_ = 0;
    LatticeRecord records_[kLanterns + 1] = {};
    Launch<LatticeParams> launch_;
};

} // namespace

JobKind latticeworkJob() {
    return fifthJob<Latticework>(
        "latticework", "quadrics below instances, holes in any-hit programs, counted shadows",
        0.003, 0.03);
}

} // namespace bench
