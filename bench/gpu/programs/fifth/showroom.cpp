// SPDX-License-Identifier: Apache-2.0
// A showroom of 3,000 goods, instances of seven meshes with textures and five finishes;
// device/showroom.cu.
#include "programs.h"

#include "device/showroom.h"

std::string_view bench_fifth_showroom_ptx();

namespace bench {
namespace {

constexpr unsigned kGoods = 7, kFloor = kGoods, kMeshes = kGoods + 1, kColors = 3;
constexpr unsigned kTextureSide = 256;

// Cubes, vases, bowls, rings, pebbles, pawns and cushions; all stand on y = 0.
Mesh makeGoods(unsigned kind, const JobSettings& settings) {
    const auto p = [](float r, float y) { return make_float2(r, y); };
    const unsigned sectors = settings.some(600, 24);
    Mesh mesh;
    switch (kind) {
    case 0:
        return makeBox(vec(-0.4f, 0, -0.4f), vec(0.4f, 0.8f, 0.4f));
    case 1:
        return makeLathe({p(0.001f, 0), p(0.3f, 0), p(0.45f, 0.3f), p(0.42f, 0.6f), p(0.2f, 0.95f),
                          p(0.16f, 1.1f), p(0.26f, 1.25f)},
                         sectors);
    case 2:
        return makeLathe({p(0.001f, 0.02f), p(0.2f, 0.02f), p(0.42f, 0.18f), p(0.55f, 0.45f),
                          p(0.51f, 0.45f), p(0.38f, 0.22f), p(0.001f, 0.1f)},
                         sectors);
    case 3:
        return makeLathe({p(0.3f, 0), p(0.5f, 0.05f), p(0.55f, 0.2f), p(0.5f, 0.35f), p(0.3f, 0.4f),
                          p(0.25f, 0.2f), p(0.3f, 0)},
                         sectors);
    case 4:
        append(mesh, makeRock(settings.some(60000, 80)), vec(0.5f, 0.35f, 0.5f), vec(0, 0.33f, 0));
        return mesh;
    case 5:
        return makeLathe({p(0.35f, 0), p(0.33f, 0.12f), p(0.16f, 0.25f), p(0.13f, 0.7f),
                          p(0.25f, 0.75f), p(0.25f, 0.95f), p(0.15f, 1.12f), p(0.001f, 1.15f)},
                         sectors);
    default: { // pillows, as closed sheets
        const unsigned cells = settings.some(160, 12);
        return makeSheet(cells, cells, [](float u, float v) {
            const float2 c = circlePoint(u - std::floor(u));
            const float ring = std::sin(kPi * (0.002f + 0.996f * v));
            const float square = 0.6f / std::max(std::fabs(c.x), std::fabs(c.y));
            const float r = 0.75f * std::sqrt(ring) * std::min(square, 0.75f);
            return vec(r * c.x, 0.25f - 0.25f * std::cos(kPi * v), r * c.y);
        });
    }
    }
}
// Grain for relief.
std::vector<float> grain(unsigned seed) {
    std::vector<float> texels;
    for (unsigned i = 0; i < kTextureSide * kTextureSide; ++i) {
        const unsigned block = i / kTextureSide / 8 * kTextureSide + i % kTextureSide / 8;
        texels.push_back(0.15f * randomOf(block, seed) + 0.03f * randomOf(i, seed + 1));
    }
    return texels;
}

class Showroom : public Renderer {
public:
    Showroom(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        for (unsigned i = 0; i < kColors; ++i) {
            colors_.emplace_back(spots(90 + i, kTextureSide), kTextureSide);
            reliefs_.emplace_back(grain(2 * i), 1,
                                  TextureShape{.width = kTextureSide, .height = kTextureSide});
        }
        for (unsigned i = 0; i < kGoods; ++i)
            add(i, makeGoods(i, settings));
        add(kFloor, makeBox(vec(-60, -1, -60), vec(60, 0, 60)));
        ShowroomParams& p = launch_.params;
        p.room = scene_.buildInstances(place(settings.some(3000, 40)));
        p.camera = makeCamera(vec(-2.5f, 3.4f, -7), vec(0, 0.4f, -0.6f), vec(0, 1, 0), 42,
                              settings.aspect());
        p.lamps[0] = {vec(-5, 7, -3), vec(2, 0, 0), vec(0, 0, 2), vec(80, 72, 60)};
        p.lamps[1] = {vec(6, 5, 2), vec(1, 0, 0), vec(0, 1, 0), vec(26, 30, 38)};
        p.samples = 2;
        p.maxDepth = 2;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 5;
        static constexpr const char* kNames[kFinishes] = {
            "__continuation_callable__enamel", "__continuation_callable__brushed",
            "__continuation_callable__cloth", "__continuation_callable__frosted",
            "__continuation_callable__plaster"};
        const OptixModule module = programs_.load(bench_fifth_showroom_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__showroom"});
        const auto hall = programs_.miss({module, "__miss__hall"});
        const auto open = programs_.miss({module, "__miss__open"});
        const auto hit = programs_.hit({{module, "__closesthit__goods"}, {}, {}});
        std::vector<OptixProgramGroup> groups = {raygen, hall, open, hit};
        std::vector<SbtRecord<NoData>> callables;
        for (const char* name : kNames) {
            groups.push_back(programs_.continuation({module, name}));
            callables.push_back(makeRecord(groups.back()));
        }
        pipeline_ = programs_.link(
            groups, {.trace = launch_.params.maxDepth + 2, .graph = 2, .continuationCallables = 1});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(hall), makeRecord(open)});
        std::vector<SbtRecord<ShowroomRecord>> records;
        for (const ShowroomRecord& r : records_)
            records.push_back(makeRecord(hit, r));
        table_.setHits(records);
        table_.setCallables(callables);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    // A structure, and a record for each finish.
    void add(unsigned number, const Mesh& mesh) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const MeshMemory memory = uploadMesh(scene_, mesh);
        const bool isFlat = number == 0 || number == kFloor; // boxes
        const float3* const normals = isFlat ? nullptr : scene_.upload(smoothNormals(mesh));
        children_[number] = scene_.build(inputOf(memory, flags));
        for (unsigned finish = 0; finish < kFinishes; ++finish) {
            const unsigned look = (number + finish) % kColors;
            const float3 tint = finish == kBrushed   ? vec(1.1f, 1, 0.85f)
                                : finish == kFrosted ? vec(0.95f, 1.25f, 1.2f)
                                                     : colorOf(5 * number + finish) * 1.4f;
            records_.push_back({viewOf(memory), normals, colors_[look].object(),
                                reliefs_[look].object(), number == kFloor ? vec(0.7f) : tint, 1,
                                finish});
        }
    }
    std::vector<OptixInstance> place(unsigned count) const {
        std::vector<OptixInstance> all = {
            instanceOf(children_[kFloor], kIdentity, 0, kFloor * kFinishes + kPlaster)};
        for (unsigned i = 1; i <= count; ++i) {
            const float turns = float(i) * 0.381966f;
            const float2 c = circlePoint(turns - std::floor(turns));
            const float r = 0.62f * std::sqrt(float(i));
            const auto goods = unsigned(kGoods * randomOf(i, 0)),
                       finish = unsigned(float(kFinishes) * randomOf(i, 1));
            const Placement to = placed(vec(r * c.x, 0.004f, r * c.y),
                                        0.65f + 0.35f * randomOf(i, 2), randomOf(i, 3));
            all.push_back(
                instanceOf(children_[goods], to.matrix, i, goods * unsigned(kFinishes) + finish));
        }
        return all;
    }

    std::vector<Texture> colors_;
    std::vector<FloatTexture> reliefs_;
    OptixTraversableHandle children_[kMeshes] = {};
    std::vector<ShowroomRecord> records_;
    Launch<ShowroomParams> launch_;
};

} // namespace

JobKind showroomJob() {
    return fifthJob<Showroom>(
        "showroom", "closest-hit programs call callables that trace, with textures", 0.003, 0.03);
}

} // namespace bench
