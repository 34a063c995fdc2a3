// SPDX-License-Identifier: Apache-2.0
// Wax figures whose light wanders below the surface; device/subsurface.cu. The pipeline is compiled
// for motion, which the scene lacks, from PTX with lines of the source.
#include "programs.h"

#include "device/subsurface.h"

std::string_view bench_third_subsurface_ptx();

namespace bench {
namespace {

constexpr unsigned kWaxMask = 2, kFloorMask = 1;

class Subsurface : public Renderer {
public:
    Subsurface(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        addFigures(settings.some(3e5, 300));
        SubsurfaceParams& p = launch_.params;
        p.world = scene_.buildInstances(instances_);
        p.camera = makeCamera(vec(-3.4f, 3.1f, -5.8f), vec(0, 0.75f, 0), vec(0, 1, 0), 36,
                              settings.aspect());
        p.sun = normalize(vec(0.6f, 0.55f, 0.5f)); // from behind
        p.sunlight = vec(5.5f, 5, 4.2f);
        p.maxSteps = 96;
        p.samples = 2;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.usesMotionBlur = true;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        o.numPayloadValues = 8;
        o.pipelineLaunchParamsVariableName = "optixLaunchParams";
        const OptixModule module = programs_.load(bench_third_subsurface_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__renderFrame"});
        const auto radiance = programs_.miss({module, "__miss__radiance"});
        const auto shadow = programs_.miss({module, "__miss__shadow"});
        const auto hit = programs_.hit({{module, "__closesthit__radiance"}, {}, {}});
        const auto shadowHit = programs_.hit({{module, "__closesthit__shadow"}, {}, {}});
        pipeline_ =
            programs_.link({raygen, radiance, shadow, hit, shadowHit}, {.trace = 2, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(radiance), makeRecord(shadow)});
        std::vector<SbtRecord<SubsurfaceRecord>> records;
        for (const SubsurfaceRecord& r : records_) {
            records.push_back(makeRecord(hit, r));
            records.push_back(makeRecord(shadowHit, r));
        }
        table_.setHits(records);
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    void add(const Mesh& mesh, const Placement& to, unsigned mask, float3 albedo, float reach) {
        const MeshMemory memory = uploadMesh(scene_, mesh);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        OptixInstance instance =
            instanceOf(scene_.build(inputOf(memory, flags)), to.matrix, unsigned(records_.size()),
                       2 * unsigned(records_.size()));
        instance.visibilityMask = mask;
        instances_.push_back(instance);
        records_.push_back({viewOf(memory), scene_.upload(smoothNormals(mesh)), albedo, reach});
    }
    // Three rocks, a torso of a lathe and a slab on a floor.
    void addFigures(unsigned triangles) {
        const Mesh rock = makeRock(triangles);
        add(makeBox(vec(-30, -1, -30), vec(30, 0, 30)), placed(vec(0), 1, 0), kFloorMask,
            vec(0.6f, 0.58f, 0.55f), 0);
        add(rock, placed(vec(-1.9f, 0.75f, 0.4f), 0.9f, 0.1f), kWaxMask, vec(0.985f, 0.9f, 0.7f),
            0.12f);
        add(rock, placed(vec(1.9f, 0.8f, 0.2f), 0.9f, 0.6f), kWaxMask, vec(0.82f, 0.985f, 0.9f),
            0.08f);
        std::vector<float2> profile;
        const unsigned rings = std::max(8u, unsigned(std::sqrt(float(triangles) / 4)));
        for (unsigned i = 0; i <= rings; ++i) {
            const float along = float(i) / float(rings), angle = kPi * along;
            const float wave = 1 + 0.35f * std::sin(9 * along);
            profile.push_back(make_float2(0.75f * std::sin(angle) * wave, 1 - std::cos(angle)));
        }
        add(makeLathe(profile, 2 * rings), placed(vec(0, 0, 0), 1, 0), kWaxMask,
            vec(0.99f, 0.8f, 0.75f), 0.1f);
        add(makeBox(vec(-0.9f, 0, -0.12f), vec(0.9f, 0.6f, 0.12f)),
            placed(vec(-0.6f, 0, -1.7f), 1, 0.93f), kWaxMask, vec(0.97f, 0.97f, 0.98f), 0.2f);
    }

    Launch<SubsurfaceParams> launch_;
    std::vector<OptixInstance> instances_;
    std::vector<SubsurfaceRecord> records_;
};

} // namespace

JobKind subsurfaceJob() {
    return thirdJob<Subsurface>("subsurface", "random walks below the surfaces of wax", 0.01, 0.1);
}

} // namespace bench
