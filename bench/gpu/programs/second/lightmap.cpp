// SPDX-License-Identifier: Apache-2.0
// Baking of light into the texels of a hall, in four launches; device/lightmap.cu.
#include "programs.h"

#include "device/lightmap.h"

#include <cmath>
#include <cstddef>

std::string_view bench_second_lightmap_ptx();

namespace bench {
namespace {

constexpr unsigned kLaunches = 4;
constexpr int kRays = 16;

class Lightmap : public Application {
public:
    Lightmap(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context),
          count_(settings.some(2e6, 400) / kLaunches * kLaunches) {
        const Mesh hall = makeScene(SceneKind::kInterior, settings.some(1e6, 2000));
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        LightmapParams& p = launch_.params;
        p.handle = scene_.build(inputOf(uploadMesh(scene_, hall), flags));
        std::vector<float4> leaving(hall.numTriangles());
        for (unsigned i = 0; i < leaving.size(); ++i) {
            const bool isLamp = randomOf(i / 64, 5) < 0.03f;
            const float3 c = colorOf(i / 512) * (isLamp ? 6.0f : 0.15f);
            leaving[i] = make_float4(c.x, c.y, c.z, 0);
        }
        p.leaving = scene_.upload(leaving);
        addTexels(hall);
        p.raysPerTexel = kRays;
        p.bias = 1e-3f;
        p.seed = 0x9e3779b9u;
        texels_.allocate(sizeof(float4) * count_);
        p.texels = texels_.as<float4>();
    }
    void compile() override {
        programs_.options.numPayloadValues = 3;
        programs_.options.pipelineLaunchParamsVariableName = "bake";
        OptixModuleCompileBoundValueEntry bound = {};
        bound.pipelineParamOffsetInBytes = offsetof(LightmapParams, raysPerTexel);
        bound.sizeInBytes = sizeof(int);
        bound.boundValuePtr = &kRays;
        bound.annotation = "rays per texel";
        programs_.moduleOptions.boundValues = &bound;
        programs_.moduleOptions.numBoundValues = 1;
        const OptixModule module = programs_.load(bench_second_lightmap_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__bake"});
        const auto miss = programs_.miss({module, "__miss__sky"});
        const auto hit = programs_.hit({{module, "__closesthit__light"}, {}, {}});
        pipeline_ = programs_.link({raygen, miss, hit}, {});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        table_.setHits(std::vector{makeRecord(hit)});
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override {
        for (unsigned i = 0; i < kLaunches; ++i) {
            launch_.params.firstTexel = i * (count_ / kLaunches);
            launch_.run(pipeline_, table_, count_ / kLaunches);
        }
    }
    std::vector<float> picture() override { return texels_.download<float>(); }

private:
    // Texels in the order of triangles, as charts of an atlas have them; some are empty.
    void addTexels(const Mesh& hall) {
        std::vector<float4> positions(count_), normals(count_);
        for (unsigned i = 0; i < count_; ++i) {
            const auto triangle = size_t(i) * hall.numTriangles() / count_;
            const float u = randomOf(i, 1), v = randomOf(i, 2) * (1 - u);
            const float3 a = vertexOf(hall, triangle, 0), b = vertexOf(hall, triangle, 1),
                         c = vertexOf(hall, triangle, 2);
            const float3 across = cross(b - a, c - a);
            const float size = length(across);
            float3 normal = size > 0 ? across / size : vec(0, 1, 0);
            const float3 p = a * (1 - u - v) + b * u + c * v;
            // Towards the middle of the hall.
            if (dot(normal, vec(0, 5, 0) - p) < 0)
                normal = -normal;
            positions[i] = make_float4(p.x, p.y, p.z, randomOf(i / 8, 3) < 0.1f ? 0.0f : 1.0f);
            normals[i] = make_float4(normal.x, normal.y, normal.z, 0);
        }
        launch_.params.positions = scene_.upload(positions);
        launch_.params.normals = scene_.upload(normals);
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<LightmapParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer texels_;
    unsigned count_;
};

} // namespace

JobKind lightmapJob() {
    return secondJob<Lightmap>("lightmap", "16 rays for each of two million texels, a bound value",
                               0.002, 0.02);
}

} // namespace bench
