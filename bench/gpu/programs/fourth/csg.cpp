// SPDX-License-Identifier: Apache-2.0
// Machine parts as expressions over solids: unions, intersections and differences; device/csg.cu.
#include "programs.h"

#include "device/csg.h"

std::string_view bench_fourth_csg_ptx();

namespace bench {
namespace {

enum Solid : unsigned char {
    kBlock,
    kBall,
    kBoreX,
    kBoreY,
    kBoreZ,
    kRing,
    kGear,
    kDisk,
    kSlots,              // eight of them
    kHoles = kSlots + 8, // eight of them
    kSolids = kHoles + 8
};

Mesh makeTorus(float radius, float thickness, unsigned sectors) {
    std::vector<float2> profile;
    for (unsigned i = 0; i <= sectors / 3; ++i) {
        const float2 c = circlePoint(float(i % (sectors / 3)) / float(sectors / 3));
        profile.push_back(make_float2(radius + thickness * c.x, thickness * c.y));
    }
    return makeLathe(profile, sectors);
}
Mesh makeBall(float radius, unsigned sectors) {
    std::vector<float2> profile;
    for (unsigned i = 0; i <= sectors / 2; ++i) {
        const float2 c = circlePoint(0.5f * (0.002f + 0.996f * float(i) / float(sectors / 2)));
        profile.push_back(make_float2(radius * c.y, -radius * c.x));
    }
    return makeLathe(profile, sectors);
}
Mesh makeBore(float radius, float half, unsigned sectors, unsigned teeth = 0) {
    return makeLathe({make_float2(1e-4f, -half), make_float2(radius, -half),
                      make_float2(radius, half), make_float2(1e-4f, half)},
                     sectors, teeth);
}
// Its y axis becomes the z axis, or after two turns the x axis.
Mesh turned(Mesh mesh, unsigned turns) {
    for (; turns > 0; --turns)
        for (size_t i = 0; i < mesh.vertices.size(); i += 3)
            std::rotate(&mesh.vertices[i], &mesh.vertices[i + 2], &mesh.vertices[i] + 3);
    return mesh;
}

Mesh makeSolid(unsigned solid, unsigned sectors) {
    switch (solid) {
    case kBlock:
        return makeBox(vec(-0.8f), vec(0.8f));
    case kBall:
        return makeBall(1.05f, sectors);
    case kBoreY:
        return makeBore(0.45f, 1.5f, sectors);
    case kBoreZ:
        return turned(makeBore(0.45f, 1.51f, sectors), 1);
    case kBoreX:
        return turned(makeBore(0.45f, 1.52f, sectors), 2);
    case kRing:
        return makeTorus(0.92f, 0.13f, sectors);
    case kGear:
        return makeBore(1, 0.35f, sectors, 18);
    case kDisk:
        return makeBore(0.7f, 0.21f, sectors);
    default:
        break;
    }
    const unsigned number = (solid - kSlots) % 8;
    const float2 c = circlePoint(float(number) / 8);
    Mesh mesh;
    if (solid < kHoles) { // in a row through the block
        const float at = 0.17f * (float(number) - 3.5f);
        append(mesh, makeBox(vec(-1.1f, at - 0.05f, 0.55f), vec(1.1f, at + 0.051f, 1.1f)), vec(1),
               vec(0));
    } else {
        append(mesh, makeBore(0.12f, 0.9f, sectors / 4), vec(1),
               vec(0.62f * c.x, 0.013f, 0.62f * c.y));
    }
    return mesh;
}

class Csg : public Renderer {
public:
    Csg(OptixDeviceContext context, const JobSettings& settings) : Renderer(context, settings) {
        MaterialMesh mesh;
        mesh.looks.resize(kSolids);
        for (unsigned i = 0; i < kSolids; ++i)
            append(mesh, makeSolid(i, settings.some(720, 72)), vec(1), vec(0), i);
        const OptixTraversableHandle solids = buildMaterials(scene_, mesh, memory_);
        writeExpressions();
        std::vector<OptixInstance> all;
        std::vector<CsgPart> expressions;
        const unsigned across = unsigned(std::sqrt(settings.some(144, 4)));
        for (unsigned i = 0; i < across * across; ++i) {
            const float3 at = vec(2.7f * (float(i % across) - 0.5f * float(across)), 0,
                                  2.7f * (float(i / across) - 0.5f * float(across)));
            const Placement to = placed(at, 0.9f, randomOf(i, 0));
            all.push_back(instanceOf(solids, to.matrix, i, 0));
            expressions.push_back(parts_[unsigned(float(kParts) * randomOf(i, 1))]);
            expressions.back().color = colorOf(i);
            expressions.back().mirror = i % 3 == 0 ? 0.45f : 0.0f;
        }
        CsgParams& p = launch_.params;
        p.parts = scene_.buildInstances(all);
        p.expressions = scene_.upload(expressions);
        p.steps = scene_.upload(steps_);
        const float back = 1.35f * float(across);
        p.camera =
            makeCamera(vec(-0.45f * back, 4.4f, -back - 1.2f),
                       vec(0.1f * back, -1, 2 - 0.55f * back), vec(0, 1, 0), 42, settings.aspect());
        p.sun = normalize(vec(-0.6f, 0.75f, -0.3f));
        p.floor = -1.4f;
        p.samples = 1;
        p.openRays = 2;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 6;
        const OptixModule module = programs_.load(bench_fourth_csg_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__solids"});
        const auto miss = programs_.miss({module, "__miss__nothing"});
        const auto hit = programs_.hit({{module, "__closesthit__face"}, {}, {}});
        pipeline_ = programs_.link({raygen, miss, hit}, {.trace = 1, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        std::vector<SbtRecord<CsgRecord>> records;
        for (unsigned i = 0; i < kSolids; ++i)
            records.push_back(makeRecord(hit, CsgRecord{viewOf(memory_), i}));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    static constexpr unsigned kParts = 6;

    using Steps = std::vector<unsigned char>;
    static Steps combine(unsigned char operation, Steps first, const Steps& second) {
        first.insert(first.end(), second.begin(), second.end());
        first.push_back(operation);
        return first;
    }
    static Steps eight(unsigned char first) {
        Steps all = {first};
        for (unsigned char i = 1; i < 8; ++i)
            all = combine(kCsgUnion, all, {(unsigned char)(first + i)});
        return all;
    }
    void writeExpressions() {
        const Steps bores = combine(kCsgUnion, combine(kCsgUnion, {kBoreX}, {kBoreY}), {kBoreZ});
        const Steps rounded = combine(kCsgBoth, {kBlock}, {kBall});
        const Steps drilled = combine(kCsgWithout, rounded, bores);
        const Steps wheel =
            combine(kCsgWithout, {kGear}, combine(kCsgUnion, {kBoreY}, eight(kHoles)));
        const Steps all[kParts] = {
            drilled,
            combine(kCsgUnion, drilled, {kRing}),
            combine(kCsgWithout, rounded, combine(kCsgUnion, {kBoreY}, eight(kSlots))),
            wheel,
            combine(kCsgUnion, combine(kCsgWithout, {kGear}, {kDisk}), {kBoreY}),
            combine(kCsgWithout, combine(kCsgUnion, rounded, {kRing}),
                    combine(kCsgUnion, eight(kSlots), eight(kHoles)))};
        for (unsigned i = 0; i < kParts; ++i) {
            parts_[i] = {unsigned(steps_.size()), unsigned(all[i].size()), vec(0), 0};
            steps_.insert(steps_.end(), all[i].begin(), all[i].end());
        }
    }

    MeshMemory memory_;
    Steps steps_;
    CsgPart parts_[kParts] = {};
    Launch<CsgParams> launch_;
};

} // namespace

JobKind csgJob() {
    return fourthJob<Csg>("csg", "expressions over solids, evaluated between all faces along a ray",
                          0.005, 0.05);
}

} // namespace bench
