// SPDX-License-Identifier: Apache-2.0
// Cut gems that part light by its wavelength; device/dispersion.cu. Rays have payload types, and
// the closest-hit program of gems traces further ones.
#include "programs.h"

#include "device/dispersion.h"

std::string_view bench_third_dispersion_ptx();

namespace bench {
namespace {

constexpr unsigned kCuts = 3;

// Facets between rings whose corners alternate.
Mesh makeGem(unsigned cut) {
    const unsigned sides = cut == 1 ? 8 : 16;
    const float table = cut == 2 ? 0.35f : 0.55f, crown = cut == 1 ? 0.5f : 0.36f;
    const float2 rings[] = {make_float2(0.001f, -0.85f),     make_float2(0.5f, -0.44f),
                            make_float2(1, -0.03f),          make_float2(1, 0.03f),
                            make_float2(0.8f, 0.6f * crown), make_float2(table, crown),
                            make_float2(0.001f, crown)};
    Mesh mesh;
    for (unsigned ring = 0; ring < std::size(rings); ++ring)
        for (unsigned s = 0; s < sides; ++s) {
            const float half = ring == 1 || ring == 4 ? 0.5f : 0.0f;
            const float2 c = circlePoint((float(s) + half) / float(sides));
            mesh.vertices.insert(mesh.vertices.end(),
                                 {rings[ring].x * c.x, rings[ring].y, rings[ring].x * c.y});
        }
    for (unsigned ring = 0; ring + 1 < std::size(rings); ++ring)
        for (unsigned s = 0; s < sides; ++s) {
            const unsigned next = (s + 1) % sides;
            const unsigned a = ring * sides + s, b = ring * sides + next;
            const unsigned c = a + sides, d = ring * sides + sides + next;
            if (ring == 1 || ring == 4) // from corners to middles
                mesh.indices.insert(mesh.indices.end(), {a, c, d, a, d, b});
            else
                mesh.indices.insert(mesh.indices.end(), {a, c, b, b, c, d});
        }
    return mesh;
}

class Dispersion : public Renderer {
public:
    Dispersion(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
        std::vector<OptixInstance> all;
        OptixTraversableHandle gems[kCuts];
        for (unsigned i = 0; i < kCuts; ++i) {
            const MeshMemory memory = uploadMesh(scene_, makeGem(i));
            gems[i] = scene_.build(inputOf(memory, flags));
            gems_[i].mesh = viewOf(memory);
            gems_[i].index = 1.5f + 0.35f * float(i);
            gems_[i].dispersion = 0.012f + 0.012f * float(i);
            gems_[i].absorption =
                vec(0.05f + 0.2f * float(i == 1), 0.1f, 0.05f + 0.3f * float(i == 2));
        }
        const MeshMemory floor =
            uploadMesh(scene_, makeBox(vec(-40, -2, -40), vec(40, -0.86f, 40)));
        floor_.mesh = viewOf(floor);
        all.push_back(instanceOf(scene_.build(inputOf(floor, flags)), kIdentity, 0, 2 * kCuts));
        const unsigned count = settings.some(900, 12);
        const auto across = unsigned(std::ceil(std::sqrt(float(count))));
        for (unsigned i = 0; i < count; ++i) {
            const float3 at =
                vec(1.6f * (float(i % across) - 0.5f * float(across)) + randomOf(i, 0), -0.2f,
                    1.6f * (float(i / across) - 1) + randomOf(i, 1));
            const Placement to = placed(at, 0.75f, randomOf(i, 2));
            all.push_back(instanceOf(gems[i % kCuts], to.matrix, i + 1, 2 * (i % kCuts)));
        }
        DispersionParams& p = launch_.params;
        p.scene = scene_.buildInstances(all);
        p.camera = makeCamera(vec(-0.5f, 3.1f, -5.6f), vec(0, -0.3f, 1.2f), vec(0, 1, 0), 44,
                              settings.aspect());
        p.sun = normalize(vec(0.5f, 0.6f, 0.5f));
        p.wavelengths = 4;
        p.maxDepth = kMaxDepth;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 0;
        const unsigned sent = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_WRITE |
                              OPTIX_PAYLOAD_SEMANTICS_CH_READ | OPTIX_PAYLOAD_SEMANTICS_MS_READ;
        const unsigned answered = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ |
                                  OPTIX_PAYLOAD_SEMANTICS_CH_WRITE |
                                  OPTIX_PAYLOAD_SEMANTICS_MS_WRITE;
        const unsigned carried =
            OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE | OPTIX_PAYLOAD_SEMANTICS_AH_READ_WRITE;
        const unsigned lightWords[] = {sent, sent, sent | answered, answered};
        const unsigned shadowWords[] = {carried, OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_WRITE |
                                                     OPTIX_PAYLOAD_SEMANTICS_AH_READ};
        OptixPayloadType types[] = {{4, lightWords}, {2, shadowWords}};
        programs_.moduleOptions.payloadTypes = types;
        programs_.moduleOptions.numPayloadTypes = 2;
        const OptixModule module = programs_.load(bench_third_dispersion_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__spectrum"});
        const auto sky = programs_.miss({module, "__miss__sky"}, &types[0]);
        const auto lit = programs_.miss({}, &types[1]);
        const OptixProgramGroup hits[] = {
            programs_.hit({{module, "__closesthit__gem"}, {}, {}}, &types[0]),
            programs_.hit({{}, {module, "__anyhit__caustic"}, {}}, &types[1]),
            programs_.hit({{module, "__closesthit__floor"}, {}, {}}, &types[0]),
            programs_.hit({{}, {module, "__anyhit__block"}, {}}, &types[1])};
        pipeline_ = programs_.link({raygen, sky, lit, hits[0], hits[1], hits[2], hits[3]},
                                   {.trace = kMaxDepth + 2, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(lit)});
        std::vector<SbtRecord<GemRecord>> records;
        for (unsigned i = 0; i < 2 * kCuts; ++i)
            records.push_back(makeRecord(hits[i % 2], gems_[i / 2]));
        records.push_back(makeRecord(hits[2], floor_));
        records.push_back(makeRecord(hits[3], floor_));
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    static constexpr unsigned kMaxDepth = 10;

    Launch<DispersionParams> launch_;
    GemRecord gems_[kCuts] = {}, floor_ = {};
};

} // namespace

JobKind dispersionJob() {
    return thirdJob<Dispersion>(
        "dispersion", "gems in four wavelengths a pixel, rays ten deep from closest-hit programs",
        0.01, 0.1);
}

} // namespace bench
