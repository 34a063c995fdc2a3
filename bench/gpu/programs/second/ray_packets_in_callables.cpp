// SPDX-License-Identifier: Apache-2.0
// Rocks whose materials are trees of continuation callables that trace;
// device/ray_packets_in_callables.cu.
#include "programs.h"

#include "device/ray_packets_in_callables.h"

std::string_view bench_second_ray_packets_in_callables_ptx();

namespace bench {
namespace {

constexpr unsigned kMaterials = 6;

// Six trees, at most three nodes deep.
std::vector<NetworkNode> makeNodes(unsigned (&roots)[kMaterials]) {
    std::vector<NetworkNode> nodes;
    const auto add = [&](unsigned kind, float3 color, float value, unsigned a = 0, unsigned b = 0) {
        nodes.push_back({kind, a, b, color, value});
        return unsigned(nodes.size() - 1);
    };
    for (unsigned i = 0; i < kMaterials; ++i) {
        const unsigned light = add(kLightNode, colorOf(3 * i), 1);
        const unsigned ambient = add(kAmbientNode, colorOf(3 * i), 1.2f);
        const unsigned mirror = add(kMirrorNode, vec(0.9f, 0.88f, 0.8f), 0.9f);
        const unsigned influence = add(kInfluenceNode, vec(0.6f), 0.9f);
        const unsigned matt = add(kSumNode, vec(0.0f), 0.55f, light, ambient);
        const unsigned tinted = add(kSumNode, vec(0.0f), 0.5f, influence, light);
        const unsigned polished = add(kSumNode, vec(0.0f), 0.3f, mirror, ambient);
        const unsigned tops[kMaterials] = {matt,
                                           tinted,
                                           add(kChoiceNode, vec(0.0f), 9, matt, polished),
                                           add(kChoiceNode, vec(0.0f), 14, tinted, mirror),
                                           add(kSumNode, vec(0.0f), 0.5f, tinted, polished),
                                           mirror};
        roots[i] = tops[i];
    }
    return nodes;
}

class RayPacketsInCallables : public Application {
public:
    RayPacketsInCallables(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height) {
        NetworkParams& p = launch_.params;
        p.nodes = scene_.upload(makeNodes(roots_));
        buildRocks(makeRoom(settings.some(6e5, 600), kMaterials));
        addInfluences(settings.some(3000, 60));
        p.camera = makeCamera(vec(0.15f, 0.25f, -0.95f), vec(0, -0.25f, 0.4f), vec(0, 1, 0), 65,
                              settings.aspect());
        p.sun = normalize(vec(-0.3f, 0.8f, -0.5f));
        p.reach = 0.4f;
        p.maxDepth = 2;
        image_.allocate(sizeof(float4) * width_ * height_);
        p.image = image_.as<float4>();
    }
    void compile() override {
        programs_.options.numPayloadValues = 4;
        programs_.options.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) |
                                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        const OptixModule module = programs_.load(bench_second_ray_packets_in_callables_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__network"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto influenceMiss = programs_.miss({module, "__miss__influence"});
        const auto network = programs_.hit({{module, "__closesthit__network"}, {}, {}});
        const auto influence = programs_.hit(
            {{}, {module, "__anyhit__influence"}, {module, "__intersection__influence"}});
        std::vector<OptixProgramGroup> groups = {raygen,        sky,     open,
                                                 influenceMiss, network, influence};
        std::vector<SbtRecord<NoData>> callables;
        const auto add = [&](OptixProgramGroup group) {
            groups.push_back(group);
            callables.push_back(makeRecord(group));
        };
        for (const char* node :
             {"__continuation_callable__light", "__continuation_callable__ambient",
              "__continuation_callable__mirror", "__continuation_callable__influence",
              "__continuation_callable__sum", "__continuation_callable__choice"})
            add(programs_.continuation({module, node}));
        add(programs_.direct({module, "__direct_callable__pattern"}));
        pipeline_ =
            programs_.link(groups, {.trace = 3, .directCallables = 1, .continuationCallables = 3});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(open), makeRecord(influenceMiss)});
        table_.setCallables(callables);
        // The record of influences has the number 1, those of rocks follow from their offsets.
        std::vector<SbtRecord<NetworkRecord>> hits;
        for (const unsigned record : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u})
            hits.push_back(record == 1 ? makeRecord(influence, NetworkRecord{})
                                       : makeRecord(network, recordOf(record)));
        table_.setHits(hits);
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    NetworkRecord recordOf(unsigned record) const {
        const unsigned material = record < 2 ? record : record - 1;
        return {vertices_, indices_, roots_[material % kMaterials]};
    }
    void buildRocks(const MaterialMesh& room) {
        // Open above, so that the sun shines into the room: without ceiling and lamp.
        std::vector<uint32_t> indices;
        std::vector<uint8_t> records;
        for (size_t i = 0; i < room.materials.size(); ++i) {
            const float* const v = &room.vertices[3 * size_t(room.indices[3 * i])];
            const bool isCeiling = i < 14 && (i == 2 || i == 3 || i >= 12);
            const bool isFront = i == 10 || i == 11;
            if (isCeiling || isFront || v[1] > 2)
                continue;
            indices.insert(indices.end(), &room.indices[3 * i], &room.indices[3 * i] + 3);
            const unsigned material = room.materials[i] % kMaterials;
            records.push_back(uint8_t(material < 1 ? material : material + 1));
        }
        vertices_ = reinterpret_cast<const float3*>(scene_.upload(room.vertices));
        indices_ = reinterpret_cast<const uint3*>(scene_.upload(indices));
        const auto address = reinterpret_cast<CUdeviceptr>(vertices_);
        const std::vector<unsigned> flags(8, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        OptixBuildInputTriangleArray& t = input.triangleArray;
        t.vertexBuffers = &address;
        t.numVertices = unsigned(room.vertices.size() / 3);
        t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        t.indexBuffer = reinterpret_cast<CUdeviceptr>(indices_);
        t.numIndexTriplets = unsigned(indices.size() / 3);
        t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
        t.flags = flags.data();
        t.numSbtRecords = unsigned(flags.size());
        t.sbtIndexOffsetBuffer = reinterpret_cast<CUdeviceptr>(scene_.upload(records));
        t.sbtIndexOffsetSizeInBytes = sizeof(uint8_t);
        launch_.params.scene = scene_.build(input);
    }
    void addInfluences(unsigned count) {
        std::vector<InfluenceBall> balls;
        std::vector<OptixAabb> boxes;
        for (unsigned i = 0; i < count; ++i) {
            const float3 c =
                vec(2 * randomOf(i, 1) - 1, 2 * randomOf(i, 2) - 1, 2 * randomOf(i, 3) - 1);
            const float r = 0.1f + 0.15f * randomOf(i, 4);
            balls.push_back({c, r, colorOf(i)});
            boxes.push_back({c.x - r, c.y - r, c.z - r, c.x + r, c.y + r, c.z + r});
        }
        launch_.params.balls = scene_.upload(balls);
        launch_.params.influences = scene_.buildBoxes(boxes, OPTIX_GEOMETRY_FLAG_NONE);
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<NetworkParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    unsigned width_, height_;
    unsigned roots_[kMaterials] = {};
    const float3* vertices_ = nullptr;
    const uint3* indices_ = nullptr;
    DeviceBuffer image_;
};

} // namespace

JobKind rayPacketsInCallablesJob() {
    return secondJob<RayPacketsInCallables>("ray_packets_in_callables",
                                            "shading networks of continuation callables that trace",
                                            0.01, 0.1);
}

} // namespace bench
