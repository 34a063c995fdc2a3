// SPDX-License-Identifier: Apache-2.0
// A forest: trees are instances of trunks and of twigs, twigs have leaves cut from textures;
// device/forest.cu.
#include "programs.h"

#include "device/forest.h"

std::string_view bench_third_forest_ptx();

namespace bench {
namespace {

constexpr unsigned kKinds = 2, kLeafSide = 128;

// A leaf in alpha: a pointed oval, or a fern.
std::vector<unsigned char> leafPicture(unsigned kind) {
    std::vector<unsigned char> texels = spots(17 + kind, kLeafSide);
    for (unsigned i = 0; i < kLeafSide * kLeafSide; ++i) {
        const float x = 2 * (float(i % kLeafSide) + 0.5f) / kLeafSide - 1;
        const float y = (float(i / kLeafSide) + 0.5f) / kLeafSide;
        float width = std::sin(kPi * y) * (1 - 0.4f * y);
        if (kind == 1)
            width *= 0.45f + 0.55f * std::fabs(std::sin(14 * y + 3 * std::fabs(x)));
        const float edge = 0.8f * width - std::fabs(x);
        texels[4 * i + 3] = (unsigned char)(255 * std::clamp(0.5f + 8 * edge, 0.0f, 1.0f));
    }
    return texels;
}

class Forest : public Renderer {
public:
    Forest(OptixDeviceContext context, const JobSettings& settings) : Renderer(context, settings) {
        for (unsigned kind = 0; kind < kKinds; ++kind) {
            textures_.emplace_back(leafPicture(kind), kLeafSide);
            trees_[kind] = makeTree(kind, settings);
        }
        const Mesh ground = makeScene(SceneKind::kTerrain, settings.some(4e5, 400));
        ForestParams& p = launch_.params;
        p.camera =
            makeCamera(vec(-46, 17, -46), vec(-10, 9, -8), vec(0, 1, 0), 50, settings.aspect());
        p.world = plant(ground, settings.some(3000, 20));
        p.sun = normalize(vec(-0.7f, 0.6f, 0.35f));
        p.samples = 2;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
        o.numPayloadValues = 6;
        const OptixModule module = programs_.load(bench_third_forest_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__forest"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto lit = programs_.miss({module, "__miss__lit"});
        const Function shade = {module, "__closesthit__shade"};
        const auto solid = programs_.hit({shade, {}, {}});
        const auto leaf = programs_.hit({shade, {module, "__anyhit__leaf"}, {}});
        const auto solidShadow = programs_.hit({});
        const auto leafShadow = programs_.hit({{}, {module, "__anyhit__dapple"}, {}});
        pipeline_ = programs_.link({raygen, sky, lit, solid, leaf, solidShadow, leafShadow},
                                   {.trace = 2, .graph = 4});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(lit)});
        std::vector<SbtRecord<ForestRecord>> records;
        for (const ForestRecord& r : records_) {
            records.push_back(makeRecord(r.texture ? leaf : solid, r));
            records.push_back(makeRecord(r.texture ? leafShadow : solidShadow, r));
        }
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    // A structure with two records; returns their place.
    OptixTraversableHandle add(const Mesh& mesh, cudaTextureObject_t texture, float3 color,
                               unsigned& record) {
        const MeshMemory memory = uploadMesh(scene_, mesh);
        const unsigned flags = texture ? OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL
                                       : OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        record = 2 * unsigned(records_.size());
        records_.push_back({viewOf(memory), texture, color, 0.35f});
        return scene_.build(inputOf(memory, flags));
    }
    // Leaves around the end of a branch.
    static Mesh makeTwig(unsigned leaves) {
        Mesh mesh;
        for (unsigned i = 0; i < leaves; ++i) {
            const float2 c = circlePoint(randomOf(i, 0)), d = circlePoint(randomOf(i, 1));
            const float r = 0.9f * std::cbrt(randomOf(i, 2)), y = 2 * randomOf(i, 3) - 1;
            const float level = std::sqrt(1 - y * y);
            const float3 at = vec(r * level * c.x, 0.6f * r * y, r * level * c.y);
            const float3 across = vec(0.09f * d.x, 0.02f, 0.09f * d.y);
            const float3 along = vec(-0.16f * d.y, 0.08f - 0.2f * randomOf(i, 4), 0.16f * d.x);
            const uint32_t first = mesh.numVertices();
            for (const float3 p :
                 {at - across, at + across, at + across + along, at - across + along})
                mesh.vertices.insert(mesh.vertices.end(), {p.x, p.y, p.z});
            for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u})
                mesh.indices.push_back(first + k);
        }
        return mesh;
    }
    OptixTraversableHandle makeTree(unsigned kind, const JobSettings& settings) {
        unsigned trunkRecord = 0, twigRecord = 0;
        const auto trunk = add(makeLathe({make_float2(0.28f, -0.5f), make_float2(0.16f, 1),
                                          make_float2(0.1f, 3), make_float2(0.02f, 4.4f)},
                                         settings.some(24, 8)),
                               0, vec(0.35f, 0.27f, 0.2f), trunkRecord);
        const auto twig = add(makeTwig(settings.some(300, 12)), textures_[kind].object(),
                              kind ? vec(0.5f, 0.75f, 0.3f) : vec(0.75f, 0.8f, 0.3f), twigRecord);
        std::vector<OptixInstance> parts = {instanceOf(trunk, kIdentity, 0, trunkRecord)};
        const unsigned twigs = settings.some(90, 8);
        for (unsigned i = 0; i < twigs; ++i) {
            const float height = randomOf(i, 5), turns = randomOf(i, 6);
            const float2 c = circlePoint(turns);
            const float r = (kind ? 1.5f * (1 - height) : 1.3f * std::sin(kPi * height)) *
                            std::sqrt(randomOf(i, 7));
            const Placement to = placed(vec(r * c.x, 1.3f + 3.2f * height, r * c.y),
                                        0.35f + 0.3f * randomOf(i, 8), turns);
            parts.push_back(instanceOf(twig, to.matrix, i + 1, twigRecord));
        }
        return scene_.buildInstances(parts);
    }
    OptixTraversableHandle plant(const Mesh& ground, unsigned trees) {
        unsigned groundRecord = 0;
        const auto soil = add(ground, 0, vec(0.4f, 0.38f, 0.25f), groundRecord);
        std::vector<OptixInstance> all = {instanceOf(soil, kIdentity, 0, groundRecord)};
        for (unsigned i = 0; i < trees; ++i) {
            const auto on = size_t(randomOf(i, 9) * float(ground.numTriangles() - 1));
            const Placement to =
                placed(vertexOf(ground, on, 0), 0.7f + 0.7f * randomOf(i, 10), randomOf(i, 11));
            all.push_back(instanceOf(trees_[i % kKinds], to.matrix, i + 1, 0));
        }
        return scene_.buildInstances(all);
    }

    Launch<ForestParams> launch_;
    std::vector<Texture> textures_;
    std::vector<ForestRecord> records_;
    OptixTraversableHandle trees_[kKinds] = {};
};

} // namespace

JobKind forestJob() {
    return thirdJob<Forest>("forest", "leaves cut from textures, in instances of instances", 0.003,
                            0.03);
}

} // namespace bench
