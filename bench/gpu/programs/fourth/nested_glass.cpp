// SPDX-License-Identifier: Apache-2.0
// Glasses with tea and wine, ice and bubbles, whose bodies overlap; device/nested_glass.cu.
#include "programs.h"

#include "device/nested_glass.h"

std::string_view bench_fourth_nested_glass_ptx();

namespace bench {
namespace {

// Words of the payload that programs read and write, or only write.
constexpr unsigned kCarried = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE |
                              OPTIX_PAYLOAD_SEMANTICS_CH_READ_WRITE |
                              OPTIX_PAYLOAD_SEMANTICS_MS_READ_WRITE;
constexpr unsigned kReplaced = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE |
                               OPTIX_PAYLOAD_SEMANTICS_CH_WRITE | OPTIX_PAYLOAD_SEMANTICS_MS_WRITE;
constexpr unsigned kSummed =
    OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE | OPTIX_PAYLOAD_SEMANTICS_AH_READ_WRITE;

class NestedGlass : public Renderer {
public:
    NestedGlass(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        makeShapes(settings);
        add(kFloor, kMedia, vec(0), vec(1), vec(0.75f, 0.7f, 0.62f));
        records_.back().isTiled = 1;
        const unsigned across = std::max(1u, unsigned(std::sqrt(settings.some(64, 4))));
        for (unsigned i = 0; i < across * across; ++i)
            pour(i,
                 vec(1.3f * (float(i % across) - 0.5f * float(across - 1)), 0,
                     1.3f * (float(i / across) - 0.5f * float(across - 1))),
                 settings.some(40, 2));
        NestedParams& p = launch_.params;
        p.table = scene_.buildInstances(instances_);
        p.camera = makeCamera(vec(-2.6f, 3.6f, -6.2f), vec(0, 0.2f, -1.2f), vec(0, 1, 0), 40,
                              settings.aspect());
        const MediumLook looks[kMedia + 1] = {{vec(0), 1},
                                              {vec(0.06f, 0.03f, 0.01f), 1.31f},
                                              {vec(0.12f, 0.05f, 0.1f), 1.52f},
                                              {vec(0.25f, 0.9f, 3.2f), 1.34f},
                                              {vec(0.5f, 4.5f, 3.6f), 1.36f},
                                              {vec(0), 1}};
        std::copy(std::begin(looks), std::end(looks), p.media);
        p.lamp[0] = vec(-2.5f, 6, -1);
        p.lamp[1] = vec(3, 0, 0);
        p.lamp[2] = vec(0, 0, 3);
        p.emission = vec(12, 11.5f, 10);
        p.samples = 2;
        p.maxDepth = 24;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 0;
        std::vector<unsigned> path(6, kReplaced);
        path.resize(14, kCarried);
        path.push_back(kReplaced);
        const unsigned shade[] = {kSummed, kSummed, kSummed, kSummed};
        OptixPayloadType types[] = {{unsigned(path.size()), path.data()}, {4, shade}};
        programs_.moduleOptions.payloadTypes = types;
        programs_.moduleOptions.numPayloadTypes = 2;
        const OptixModule module = programs_.load(bench_fourth_nested_glass_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__drinks"});
        const auto room = programs_.miss({module, "__miss__room"}, &types[0]);
        const auto lit = programs_.miss({}, &types[1]);
        const OptixProgramGroup hits[] = {
            programs_.hit({{module, "__closesthit__solid"}, {}, {}}, &types[0]),
            programs_.hit({{}, {module, "__anyhit__solid"}, {}}, &types[1]),
            programs_.hit({{module, "__closesthit__body"}, {}, {}}, &types[0]),
            programs_.hit({{}, {module, "__anyhit__body"}, {}}, &types[1])};
        pipeline_ = programs_.link({raygen, room, lit, hits[0], hits[1], hits[2], hits[3]},
                                   {.trace = 2, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(room), makeRecord(lit)});
        std::vector<SbtRecord<NestedRecord>> records;
        for (const NestedRecord& r : records_)
            for (unsigned ray = 0; ray < 2; ++ray)
                records.push_back(makeRecord(hits[(r.medium == kMedia ? 0 : 2) + ray], r));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    enum Shape : unsigned { kFloor, kGoblet, kFill, kCube, kBall, kCoaster, kShapes };

    void makeShapes(const JobSettings& settings) {
        const auto p = [](float r, float y) { return make_float2(r, y); };
        const unsigned sectors = settings.some(600, 24);
        const Mesh shapes[kShapes] = {
            makeBox(vec(-30, -0.2f, -30), vec(30, 0, 30)),
            makeLathe({p(0.001f, 0), p(0.42f, 0), p(0.45f, 0.05f), p(0.5f, 1.3f), p(0.46f, 1.32f),
                       p(0.41f, 0.12f), p(0.38f, 0.08f), p(0.001f, 0.08f)},
                      sectors),
            // It reaches into the glass.
            makeLathe({p(0.001f, 0.06f), p(0.4f, 0.07f), p(0.43f, 0.12f), p(0.465f, 0.9f),
                       p(0.001f, 0.9f)},
                      sectors),
            makeBox(vec(-1), vec(1)), makeRock(settings.some(2000, 60)),
            makeLathe({p(0.001f, 0.001f), p(0.6f, 0.001f), p(0.6f, 0.02f), p(0.001f, 0.02f)},
                      sectors)};
        const unsigned flags = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
        for (unsigned i = 0; i < kShapes; ++i) {
            const MeshMemory memory = uploadMesh(scene_, shapes[i]);
            shapes_[i] = scene_.build(inputOf(memory, flags));
            views_[i] = viewOf(memory);
        }
    }
    void add(Shape shape, unsigned medium, float3 at, float3 scale, float3 color = vec(0),
             float turns = 0) {
        const float2 c = circlePoint(turns);
        const float m[12] = {scale.x * c.x,  0, scale.z * c.y, at.x, 0, scale.y, 0, at.y,
                             -scale.x * c.y, 0, scale.z * c.x, at.z};
        instances_.push_back(instanceOf(shapes_[shape], m, 0, 2 * unsigned(records_.size())));
        records_.push_back({views_[shape], color, medium, 0});
    }
    // A glass with its drink; ice swims at the surface, bubbles below.
    void pour(unsigned number, float3 at, unsigned bubbles) {
        add(kCoaster, kMedia, at, vec(1), colorOf(number));
        add(kGoblet, kTumbler, at + vec(0, 0.021f, 0), vec(1));
        add(kFill, number % 2 ? kTea : kWine, at + vec(0, 0.021f, 0), vec(1));
        for (unsigned i = 0; i < number % 4; ++i) {
            const float2 c = circlePoint(float(i) / 3);
            add(kCube, kIce, at + vec(0.2f * c.x, 0.83f, 0.2f * c.y), vec(0.11f), vec(0),
                randomOf(number * 4 + i, 0));
        }
        for (unsigned i = 0; i < bubbles; ++i) {
            const float2 c = circlePoint(randomOf(number * 64 + i, 1));
            const float r = 0.36f * std::sqrt(randomOf(number * 64 + i, 2));
            add(kBall, kBubble,
                at + vec(r * c.x, 0.15f + 0.6f * randomOf(number * 64 + i, 3), r * c.y),
                vec(0.008f + 0.014f * randomOf(number * 64 + i, 4)));
        }
    }

    OptixTraversableHandle shapes_[kShapes] = {};
    MeshView views_[kShapes] = {};
    std::vector<OptixInstance> instances_;
    std::vector<NestedRecord> records_;
    Launch<NestedParams> launch_;
};

} // namespace

JobKind nestedGlassJob() {
    return fourthJob<NestedGlass>(
        "nested_glass", "drinks, ice and bubbles as overlapping media, with coloured shadows", 0.01,
        0.1);
}

} // namespace bench
