// SPDX-License-Identifier: Apache-2.0
// Thousands of bodies over a pool: in each frame CUDA kernels write the instances and the waves,
// the pool's structure is updated and that of the instances is built; device/rigid_bodies.cu.
#include "programs.h"

#include "device/rigid_bodies.h"

std::string_view bench_fourth_rigid_bodies_ptx();
std::string_view bench_fourth_rigid_bodies_kernels_ptx();

namespace bench {
namespace {

enum Material : unsigned { kMattBody, kMetalBody, kPlasticBody, kGlassBody, kMaterials };

class RigidBodies : public Renderer {
public:
    RigidBodies(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings),
          pool_(context, OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_PREFER_FAST_TRACE),
          world_(context, OPTIX_BUILD_FLAG_PREFER_FAST_BUILD) {
        makeShapes(settings);
        makePool(settings);
        motion_.bodies = settings.some(2000, 60);
        instances_.allocate((motion_.bodies + 2) * sizeof(OptixInstance));
        motion_.instances = instances_.as<OptixInstance>();
        BodyParams& p = launch_.params;
        p.camera = makeCamera(vec(-17, 13, -25), vec(0, 0, 0), vec(0, 1, 0), 46, settings.aspect());
        p.sun = normalize(vec(-0.5f, 0.8f, -0.35f));
        p.samples = 2;
        p.bounces = 4;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        const OptixModule module = programs_.load(bench_fourth_rigid_bodies_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__bodies"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto lit = programs_.miss({module, "__miss__lit"});
        const auto bounce = programs_.hit({{module, "__closesthit__bounce"}, {}, {}});
        const OptixProgramGroup materials[kMaterials] = {
            programs_.direct({module, "__direct_callable__matt"}),
            programs_.direct({module, "__direct_callable__metal"}),
            programs_.direct({module, "__direct_callable__plastic"}),
            programs_.direct({module, "__direct_callable__glass"})};
        pipeline_ = programs_.link(
            {raygen, sky, lit, bounce, materials[0], materials[1], materials[2], materials[3]},
            {.trace = 2, .graph = 2, .directCallables = 1});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(lit)});
        std::vector<SbtRecord<BodyRecord>> records;
        for (const BodyRecord& r : records_)
            records.push_back(makeRecord(bounce, r));
        table_.setHits(records);
        table_.setCallables(std::vector{makeRecord(materials[0]), makeRecord(materials[1]),
                                        makeRecord(materials[2]), makeRecord(materials[3])});
        kernels_ = std::make_unique<Kernels>(bench_fourth_rigid_bodies_kernels_ptx());
    }
    void renderFrame() override {
        motion_.time = 0.07f * float(frame_ % 8);
        kernels_->run("moveWater", motion_.waterVertices, motion_);
        kernels_->run("moveBodies", motion_.bodies, motion_);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        pool_.build(inputOf(water_, flags),
                    frame_++ == 0 ? OPTIX_BUILD_OPERATION_BUILD : OPTIX_BUILD_OPERATION_UPDATE);
        OptixInstance still[2] = {
            instanceOf(floor_, kIdentity, 0, kBodyShapes * kMaterials),
            instanceOf(pool_.handle(), kIdentity, 0, kBodyShapes * kMaterials + 1)};
        still[1].visibilityMask = 2; // it throws no shadow
        CUDA_CHECK(cudaMemcpyAsync(instances_.data(), still, sizeof(still), cudaMemcpyHostToDevice,
                                   nullptr));
        world_.build(inputOfInstances(instances_.address(), motion_.bodies + 2),
                     OPTIX_BUILD_OPERATION_BUILD);
        launch_.params.world = world_.handle();
        launch_.run(pipeline_, table_, width_, height_);
    }

private:
    void makeShapes(const JobSettings& settings) {
        const auto p = [](float r, float y) { return make_float2(r, y); };
        const unsigned sectors = settings.some(240, 24), flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const Mesh shapes[kBodyShapes] = {
            makeRock(settings.some(60000, 80)),
            makeBox(vec(-0.8f), vec(0.8f)),
            makeLathe({p(0.001f, -1), p(0.5f, -0.9f), p(0.9f, -0.2f), p(0.9f, 0.2f), p(0.5f, 0.9f),
                       p(0.001f, 1)},
                      sectors),
            makeLathe({p(0.4f, -0.3f), p(1, -0.3f), p(1, 0.3f), p(0.4f, 0.3f), p(0.4f, -0.3f)},
                      sectors, 14),
            makeBox(vec(-1, -0.3f, -0.5f), vec(1, 0.3f, 0.5f)),
            makeLathe({p(0.001f, -0.8f), p(0.9f, -0.8f), p(0.001f, 0.9f)}, sectors),
            makeRock(settings.some(3000, 40)),
            makeLathe({p(0.001f, -1), p(0.3f, -1), p(0.3f, 1), p(0.001f, 1)}, sectors)};
        for (unsigned i = 0; i < kBodyShapes; ++i) {
            const MeshMemory memory = uploadMesh(scene_, shapes[i]);
            motion_.shapes[i] = scene_.build(inputOf(memory, flags));
            views_[i] = viewOf(memory);
        }
        for (unsigned i = 0; i < kBodyShapes * kMaterials; ++i)
            records_.push_back({views_[i % kBodyShapes],
                                i / kBodyShapes == kGlassBody ? vec(0.95f) : colorOf(i), 0.15f,
                                i / kBodyShapes});
        const MeshMemory floor = uploadMesh(scene_, makeBox(vec(-60, -2, -60), vec(60, -1.2f, 60)));
        floor_ = scene_.build(inputOf(floor, flags));
        records_.push_back({viewOf(floor), vec(0.55f, 0.5f, 0.42f), 1, kMattBody});
    }
    void makePool(const JobSettings& settings) {
        const unsigned cells = unsigned(std::sqrt(settings.some(2.5e5, 100)));
        std::vector<float2> rest;
        const Mesh sheet = makeSheet(cells, cells, [&](float u, float v) {
            rest.push_back(make_float2(40 * v - 20, 40 * u - 20));
            return vec(40 * v - 20, 0, 40 * u - 20);
        });
        water_ = uploadMesh(scene_, sheet);
        motion_.water = reinterpret_cast<float3*>(water_.vertices);
        motion_.rest = scene_.upload(rest);
        motion_.waterVertices = water_.vertexCount;
        records_.push_back({viewOf(water_), vec(0.8f, 0.93f, 0.95f), 0, kGlassBody});
    }

    BodyMotion motion_ = {};
    MeshMemory water_;
    MeshView views_[kBodyShapes] = {};
    std::vector<BodyRecord> records_;
    LiveStructure pool_, world_;
    OptixTraversableHandle floor_ = 0;
    DeviceBuffer instances_;
    std::unique_ptr<Kernels> kernels_;
    Launch<BodyParams> launch_;
    unsigned frame_ = 0;
};

} // namespace

JobKind rigidBodiesJob() {
    return fourthJob<RigidBodies>(
        "rigid_bodies",
        "thousands of bodies that kernels move, over waves, with callables as materials", 0.01,
        0.1);
}

} // namespace bench
