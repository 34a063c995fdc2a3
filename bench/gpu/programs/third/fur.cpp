// SPDX-License-Identifier: Apache-2.0
// Long hair of Catmull-Rom curves with the lobes of Marschner; device/fur.cu. Its pipeline has four
// modules: rays, strands, lobes, and the intersection of curves.
#include "programs.h"

#include "device/fur.h"

std::string_view bench_third_fur_ptx();
std::string_view bench_third_fur_lobes_ptx();
std::string_view bench_third_fur_strands_ptx();

namespace bench {
namespace {

constexpr unsigned kPoints = 12, kSegments = kPoints - 3;
constexpr unsigned kFurFlags = OPTIX_BUILD_FLAG_ALLOW_COMPACTION |
                               OPTIX_BUILD_FLAG_PREFER_FAST_TRACE |
                               OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;

class Fur : public Renderer {
public:
    Fur(OptixDeviceContext context, const JobSettings& settings) : Renderer(context, settings) {
        const MeshMemory head = uploadMesh(scene_, makeRock(settings.some(20000, 100)));
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        skin_.mesh = viewOf(head);
        skin_.color = vec(0.6f, 0.45f, 0.38f);
        FurParams& p = launch_.params;
        const OptixInstance parts[] = {
            instanceOf(scene_.build(inputOf(head, flags)), placed(vec(0), 0.8f, 0).matrix, 0, 0),
            instanceOf(growHair(settings.some(60000, 60)), kIdentity, 1, kRayTypes)};
        p.world = scene_.buildInstances({std::begin(parts), std::end(parts)});
        p.camera = makeCamera(vec(-2.3f, 0.8f, -4.9f), vec(0, -0.3f, 0), vec(0, 1, 0), 40,
                              settings.aspect());
        p.lights[0] = {normalize(vec(-0.6f, 0.7f, -0.5f)), vec(2.6f, 2.4f, 2.1f)};
        p.lights[1] = {normalize(vec(0.7f, 0.4f, 0.8f)), vec(3.5f, 3.4f, 3.6f)};
        p.samples = 2;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE) |
                                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CATMULLROM);
        o.numPayloadValues = 3;
        const OptixModule rays = programs_.load(bench_third_fur_ptx());
        const OptixModule strands = programs_.load(bench_third_fur_strands_ptx());
        const OptixModule lobes = programs_.load(bench_third_fur_lobes_ptx());
        const OptixModule curves =
            programs_.builtin(OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM, kFurFlags);
        const auto raygen = programs_.raygen({rays, "__raygen__groom"});
        const auto backdrop = programs_.miss({rays, "__miss__backdrop"});
        const auto lit = programs_.miss({});
        const OptixProgramGroup hits[] = {
            programs_.hit({{rays, "__closesthit__skin"}, {}, {}}),
            programs_.hit({{}, {rays, "__anyhit__solid"}, {}}),
            programs_.hit({{strands, "__closesthit__strand"}, {}, {curves, nullptr}}),
            programs_.hit({{}, {strands, "__anyhit__veil"}, {curves, nullptr}})};
        const OptixProgramGroup callables[] = {
            programs_.direct({lobes, "__direct_callable__reflected"}),
            programs_.direct({lobes, "__direct_callable__transmitted"}),
            programs_.direct({lobes, "__direct_callable__twice"})};
        pipeline_ = programs_.link({raygen, backdrop, lit, hits[0], hits[1], hits[2], hits[3],
                                    callables[0], callables[1], callables[2]},
                                   {.trace = 2, .graph = 2, .directCallables = 1});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(backdrop), makeRecord(lit)});
        std::vector<SbtRecord<FurRecord>> records;
        for (unsigned i = 0; i < 2 * kRayTypes; ++i)
            records.push_back(makeRecord(hits[i], i < kRayTypes ? skin_ : hair_));
        table_.setHits(records);
        table_.setCallables(std::vector{makeRecord(callables[0]), makeRecord(callables[1]),
                                        makeRecord(callables[2])});
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    static constexpr unsigned kRayTypes = 2;

    // Strands from the upper part of the head that fall in locks.
    OptixTraversableHandle growHair(unsigned strands) {
        std::vector<float4> points;
        std::vector<unsigned> firsts;
        for (unsigned s = 0; s < strands; ++s) {
            const float y = 1 - 1.3f * randomOf(s, 0), level = std::sqrt(std::max(0.0f, 1 - y * y));
            const float2 c = circlePoint(randomOf(s, 1));
            const float3 out = vec(level * c.x, y, level * c.y);
            const auto lock = unsigned(24 * randomOf(s, 1)) + 100 * unsigned(4 * randomOf(s, 0));
            float3 p = out * 0.75f, step = out * 0.16f;
            for (unsigned i = 0; i < kPoints; ++i) {
                if (i < kSegments)
                    firsts.push_back(unsigned(points.size()));
                points.push_back(make_float4(p.x, p.y, p.z, 0.0032f * (1.1f - float(i) / kPoints)));
                step = step * 0.86f + vec(0, -0.028f, 0);
                const float2 turn = circlePoint(randomOf(lock, 2));
                const float wave = 0.05f * std::sin(1.3f * float(i) + 6 * randomOf(lock, 3));
                p += step + vec(turn.x, 0, turn.y) * wave +
                     vec(randomOf(s, 4) - 0.5f, 0, randomOf(s, 5) - 0.5f) * 0.02f;
                if (length(p) < 0.98f)
                    p = normalize(p) * 0.98f;
            }
        }
        const CUdeviceptr vertices = addressOf(scene_, points),
                          widths = vertices + 3 * sizeof(float);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
        input.curveArray.curveType = OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM;
        input.curveArray.vertexBuffers = &vertices;
        input.curveArray.vertexStrideInBytes = input.curveArray.widthStrideInBytes = sizeof(float4);
        input.curveArray.numVertices = unsigned(points.size());
        input.curveArray.widthBuffers = &widths;
        input.curveArray.indexBuffer = addressOf(scene_, firsts);
        input.curveArray.indexStrideInBytes = sizeof(unsigned);
        input.curveArray.numPrimitives = unsigned(firsts.size());
        input.curveArray.flag = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
        hair_.absorption = vec(0.35f, 0.7f, 1.4f);
        hair_.roughness = 0.25f;
        return scene_.build(input, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
    }

    Launch<FurParams> launch_;
    FurRecord skin_ = {}, hair_ = {};
};

} // namespace

JobKind furJob() {
    return thirdJob<Fur>(
        "fur", "half a million curves with any-hit programs, and lobes in callables", 0.01, 0.1);
}

} // namespace bench
