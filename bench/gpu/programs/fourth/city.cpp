// SPDX-License-Identifier: Apache-2.0
// A city of 50,000 buildings, trees and cars, instances of 30 meshes, in haze; device/city.cu.
#include "programs.h"

#include "device/city.h"

std::string_view bench_fourth_city_ptx();

namespace bench {
namespace {

constexpr unsigned kBuildings = 20, kTrees = 5, kCars = 5, kMeshes = kBuildings + kTrees + kCars;

// Towers on a base of side 1, of height 1: setbacks, ledges, and masts.
Mesh makeBuilding(unsigned kind, unsigned detail) {
    Mesh mesh;
    const unsigned tiers = 1 + kind % 4;
    for (unsigned t = 0; t < tiers; ++t) {
        const float half = 0.5f - 0.09f * float(t);
        const float low = float(t) / float(tiers), high = float(t + 1) / float(tiers);
        append(mesh, makeBox(vec(-half, low, -half), vec(half, high, half)), vec(1), vec(0));
        const unsigned ledges = detail * (1 + kind % 3) / tiers;
        for (unsigned i = 0; i < ledges; ++i) {
            const float y = low + (high - low) * float(i) / float(ledges), out = half + 0.012f;
            append(mesh, makeBox(vec(-out, y, -out), vec(out, y + 0.003f, out)), vec(1), vec(0));
        }
    }
    if (kind % 5 == 0)
        append(mesh, makeBox(vec(-0.01f, 1, -0.01f), vec(0.01f, 1.25f, 0.01f)), vec(1), vec(0));
    if (kind % 3 == 1) {
        const float2 dome[] = {make_float2(0.3f, 1), make_float2(0.28f, 1.05f),
                               make_float2(0.2f, 1.1f), make_float2(0.01f, 1.13f)};
        append(mesh, makeLathe({std::begin(dome), std::end(dome)}, 8 * detail), vec(1), vec(0));
    }
    return mesh;
}
Mesh makeTree(unsigned kind, unsigned detail) {
    Mesh mesh = makeLathe({make_float2(0.08f, 0), make_float2(0.04f, 0.6f)}, 6);
    for (unsigned i = 0; i < 3 + kind; ++i)
        append(mesh, makeRock(30 * detail), vec(0.28f + 0.1f * randomOf(kind * 8 + i, 0)),
               vec(0.5f * randomOf(kind * 8 + i, 1) - 0.25f, 0.6f + 0.1f * float(i),
                   0.5f * randomOf(kind * 8 + i, 2) - 0.25f));
    return mesh;
}
Mesh makeCar(unsigned kind, unsigned detail) {
    Mesh mesh = makeBox(vec(-0.9f, 0.2f, -0.4f), vec(0.9f, 0.6f, 0.4f));
    const float roof = 0.9f + 0.1f * float(kind);
    append(mesh, makeBox(vec(-0.6f, 0.6f, -0.35f), vec(0.4f, roof, 0.35f)), vec(1), vec(0));
    const Mesh wheel = makeLathe({make_float2(0.05f, -1), make_float2(0.2f, -1),
                                  make_float2(0.2f, 1), make_float2(0.05f, 1)},
                                 detail);
    for (const float x : {-0.6f, 0.6f})
        append(mesh, wheel, vec(1, 0.42f, 1), vec(x, 0.1f, 0));
    return mesh;
}

class City : public Renderer {
public:
    City(OptixDeviceContext context, const JobSettings& settings) : Renderer(context, settings) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT, detail = settings.some(40, 6);
        for (unsigned i = 0; i < kMeshes; ++i) {
            const MeshMemory memory = uploadMesh(scene_, meshOf(i, detail));
            children_[i] = scene_.build(inputOf(memory, flags));
            records_[i] = {viewOf(memory)};
        }
        const MeshMemory ground =
            uploadMesh(scene_, makeBox(vec(-3000, -1, -3000), vec(3000, 0, 3000)));
        children_[kMeshes] = scene_.build(inputOf(ground, flags));
        records_[kMeshes] = {viewOf(ground)};
        place(unsigned(std::sqrt(settings.some(25000, 64))));
        HazeParams& p = launch_.params;
        p.city = scene_.buildInstances(instances_);
        p.materials = scene_.upload(materials_);
        p.camera =
            makeCamera(vec(-24, 16, -30), vec(20, 4, 34), vec(0, 1, 0), 46, settings.aspect());
        p.sun = normalize(vec(0.75f, 0.33f, 0.35f));
        p.haze = 0.006f;
        p.hazeHeight = 14;
        p.hazeSteps = 6;
        p.samples = 2;
        p.maxDepth = 2;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 6;
        const OptixModule module = programs_.load(bench_fourth_city_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__city"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto lit = programs_.miss({module, "__miss__lit"});
        const auto hit = programs_.hit({{module, "__closesthit__facade"}, {}, {}});
        pipeline_ = programs_.link({raygen, sky, lit, hit}, {.trace = 4, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(lit)});
        std::vector<SbtRecord<HazeRecord>> records;
        for (const HazeRecord& r : records_)
            records.push_back(makeRecord(hit, r));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    static Mesh meshOf(unsigned i, unsigned detail) {
        return i < kBuildings            ? makeBuilding(i, detail)
               : i < kBuildings + kTrees ? makeTree(i - kBuildings, detail)
                                         : makeCar(i - kBuildings - kTrees, detail);
    }
    void add(unsigned mesh, float3 at, float3 scale, float turns, const HazeMaterial& material) {
        const float2 c = circlePoint(turns);
        const float m[12] = {scale.x * c.x,  0, scale.z * c.y, at.x, 0, scale.y, 0, at.y,
                             -scale.x * c.y, 0, scale.z * c.x, at.z};
        instances_.push_back(instanceOf(children_[mesh], m, unsigned(materials_.size()), mesh));
        materials_.push_back(material);
    }
    // A building and a tree or a car for each lot; each fourth line of lots is a street.
    void place(unsigned across) {
        add(kMeshes, vec(0), vec(1), 0, {vec(0.16f, 0.16f, 0.17f), vec(0), 0, 0});
        for (unsigned i = 0; i < across * across; ++i) {
            const unsigned x = i % across, z = i / across;
            const float3 at = vec(3.0f * (float(x + x / 4) - 0.625f * float(across)), 0,
                                  3.0f * (float(z + z / 4) - 0.625f * float(across)));
            const float2 middle = make_float2(at.x / 90, at.z / 90);
            const float rise = std::exp(-middle.x * middle.x - middle.y * middle.y);
            const float chance = randomOf(i, 1) * randomOf(i, 2);
            const float height = 2 + 3 * randomOf(i, 3) + 18 * rise * chance;
            const float width = 1.9f + 0.7f * randomOf(i, 4);
            const unsigned kind = unsigned(kBuildings * randomOf(i, 5));
            add(kind, at, vec(width, height, width), 0.25f * float(i % 4),
                {colorOf(i % 97) * 0.7f + vec(0.12f), vec(0.08f, 0.1f, 0.12f),
                 0.22f + 0.12f * randomOf(i, 6), 0.15f * randomOf(i, 7)});
            if (i % 2)
                add(kBuildings + i % kTrees, at + vec(1.5f, 0, 1.5f),
                    vec(0.7f + 0.5f * randomOf(i, 8)), randomOf(i, 9),
                    {vec(0.12f, 0.25f + 0.1f * randomOf(i, 10), 0.06f), vec(0), 0, 0});
            else
                add(kBuildings + kTrees + i % kCars,
                    at + vec(randomOf(i, 8) - 0.5f, 0, x % 4 == 3 ? 3 : 1.6f), vec(0.3f),
                    x % 4 == 3 ? 0.25f : 0, {colorOf(i), vec(0), 0, 0});
        }
    }

    OptixTraversableHandle children_[kMeshes + 1] = {};
    HazeRecord records_[kMeshes + 1] = {};
    std::vector<OptixInstance> instances_;
    std::vector<HazeMaterial> materials_;
    Launch<HazeParams> launch_;
};

} // namespace

JobKind cityJob() {
    return fourthJob<City>(
        "city", "50,000 instances of 30 meshes with materials of their own, in haze", 0.005, 0.05);
}

} // namespace bench
