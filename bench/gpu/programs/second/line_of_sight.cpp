// SPDX-License-Identifier: Apache-2.0
// Visibility between points of a landscape with trees; device/line_of_sight.cu.
#include "programs.h"

#include "device/line_of_sight.h"

#include <bit>
#include <cmath>

std::string_view bench_second_line_of_sight_ptx();

namespace bench {
namespace {

// A landscape, and leaves above it as crowns of trees.
Mesh makeForest(unsigned triangles) {
    Mesh mesh = makeScene(SceneKind::kTerrain, triangles / 2);
    const unsigned ground = mesh.numTriangles();
    for (unsigned i = 0; i < triangles / 2; ++i) {
        const unsigned tree = i / 200;
        const auto on = size_t(randomOf(tree, 0) * float(ground - 1));
        const float3 top = vertexOf(mesh, on, 0) + vec(0, 1.2f + randomOf(tree, 1), 0);
        const float size = 0.4f + 0.4f * randomOf(tree, 2);
        const auto off = [&](unsigned k) {
            return size * (randomOf(i, k) + randomOf(i, k + 3) - 1);
        };
        const float3 at = top + vec(off(4), 1.5f * off(5), off(6));
        const auto first = mesh.numVertices();
        for (unsigned k = 0; k < 3; ++k) {
            const auto side = [&](unsigned n) { return 0.2f * (randomOf(i + 7919 * k, n) - 0.5f); };
            const float3 v = at + vec(side(10), side(11), side(12));
            mesh.vertices.insert(mesh.vertices.end(), {v.x, v.y, v.z});
            mesh.indices.push_back(first + k);
        }
    }
    return mesh;
}

class LineOfSight : public Application {
public:
    LineOfSight(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), count_(settings.some(6e5, 300)) {
        const Mesh mesh = makeForest(settings.some(2e6, 1000));
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        SightParams& p = launch_.params;
        p.world = scene_.build(inputOf(uploadMesh(scene_, mesh), flags));
        std::vector<float4> targets(count_), watchers(kWatchers);
        const auto ground = settings.some(1e6, 500) * 9 / 10;
        for (unsigned i = 0; i < count_; ++i) {
            // Neighbours in the list are neighbours on the ground.
            const float3 v = vertexOf(mesh, size_t(i) * ground / count_, 0);
            targets[i] = make_float4(v.x, v.y + 0.05f + 0.5f * randomOf(i, 1), v.z, 0);
        }
        for (unsigned i = 0; i < kWatchers; ++i) {
            const float3 v = vertexOf(mesh, size_t(randomOf(i, 3) * float(ground)), 0);
            watchers[i] = make_float4(v.x, v.y + 2 + 15 * randomOf(i, 4), v.z, 0);
        }
        p.targets = scene_.upload(targets);
        p.watchers = scene_.upload(watchers);
        p.numTargets = count_;
        seen_.allocate(sizeof(unsigned) * count_);
        p.seenBy = seen_.as<unsigned>();
    }
    void compile() override {
        programs_.options.numPayloadValues = 1;
        programs_.options.pipelineLaunchParamsVariableName = "sight";
        const OptixModule module = programs_.load(bench_second_line_of_sight_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__sight"});
        const auto miss = programs_.miss({module, "__miss__visible"});
        const auto hit = programs_.hit({});
        pipeline_ = programs_.link({raygen, miss, hit}, {});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        table_.setHits(std::vector{makeRecord(hit)});
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override { launch_.run(pipeline_, table_, count_); }
    // Numbers of bits, because a bit that differs should weigh the same wherever it is.
    std::vector<float> picture() override {
        std::vector<float> counts;
        for (const unsigned word : seen_.download<unsigned>())
            counts.insert(counts.end(),
                          {float(std::popcount(word)), float(std::popcount(word & 0x55555555u)),
                           float(std::popcount(word & 0xffffu)), 0});
        return counts;
    }

private:
    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<SightParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer seen_;
    unsigned count_;
};

} // namespace

JobKind lineOfSightJob() {
    return secondJob<LineOfSight>(
        "line_of_sight", "32 rays to watchers for each target, a miss program and no others", 1e-3,
        1e-2);
}

} // namespace bench
