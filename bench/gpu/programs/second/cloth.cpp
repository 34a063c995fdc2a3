// SPDX-License-Identifier: Apache-2.0
// Cloth whose vertices a CUDA kernel moves in each frame; the structure is updated, and built again
// when it is new; device/cloth.cu.
#include "programs.h"

#include "device/cloth.h"

#include <cmath>

std::string_view bench_second_cloth_ptx();
std::string_view bench_second_cloth_kernels_ptx();

namespace bench {
namespace {

class Cloth : public Application {
public:
    Cloth(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height),
          structure_(context, OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_PREFER_FAST_TRACE),
          world_(context, OPTIX_BUILD_FLAG_PREFER_FAST_BUILD) {
        motion_.across = unsigned(std::sqrt(settings.some(5e5, 400)));
        const size_t count = size_t(motion_.across) * motion_.across;
        motion_.vertices = scene_.allocate<float3>(count);
        motion_.normals = scene_.allocate<float3>(count);
        addGrid();
        addFloor();
        instanceMemory_.allocate(2 * sizeof(OptixInstance));
        ClothParams& p = launch_.params;
        p.camera = makeCamera(vec(-2.4f, 1.9f, -3.2f), vec(0, 0.1f, 0), vec(0, 1, 0), 50,
                              settings.aspect());
        p.sun = normalize(vec(-0.6f, 0.7f, -0.1f));
        image_.allocate(sizeof(float4) * width_ * height_);
        p.image = image_.as<float4>();
    }
    void compile() override {
        programs_.options.numPayloadValues = 4;
        programs_.options.traversableGraphFlags =
            OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        programs_.options.exceptionFlags =
            OPTIX_EXCEPTION_FLAG_STACK_OVERFLOW | OPTIX_EXCEPTION_FLAG_TRACE_DEPTH;
        const OptixModule module = programs_.load(bench_second_cloth_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__cloth"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto sun = programs_.miss({module, "__miss__sun"});
        const auto hit = programs_.hit({{module, "__closesthit__cloth"}, {}, {}});
        pipeline_ = programs_.link({raygen, sky, sun, hit}, {.trace = 3, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky), makeRecord(sun)});
        table_.setHits(std::vector{makeRecord(hit, records_[0]), makeRecord(hit, records_[1])});
        kernels_ = std::make_unique<Kernels>(bench_second_cloth_kernels_ptx());
    }
    double compileTime() const override { return programs_.compileTime(); }

    void renderFrame() override {
        motion_.time = 0.1f * float(frame_ % 8);
        kernels_->run("moveCloth", mesh_.vertexCount, motion_);
        kernels_->run("findNormals", mesh_.vertexCount, motion_);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        structure_.build(inputOf(mesh_, flags),
                         frame_ == 0 ? OPTIX_BUILD_OPERATION_BUILD : OPTIX_BUILD_OPERATION_UPDATE);
        const OptixInstance instances[2] = {instanceOf(structure_.handle(), kIdentity, 0, 0),
                                            instanceOf(floor_, kIdentity, 1, 1)};
        CUDA_CHECK(cudaMemcpyAsync(instanceMemory_.data(), instances, sizeof(instances),
                                   cudaMemcpyHostToDevice, nullptr));
        world_.build(inputOfInstances(instanceMemory_.address(), 2), OPTIX_BUILD_OPERATION_BUILD);
        launch_.params.scene = world_.handle();
        launch_.run(pipeline_, table_, width_, height_);
        ++frame_;
    }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    void addGrid() {
        const unsigned n = motion_.across;
        std::vector<uint32_t> indices;
        for (unsigned y = 0; y + 1 < n; ++y)
            for (unsigned x = 0; x + 1 < n; ++x) {
                const unsigned a = y * n + x, b = a + 1, c = a + n, d = c + 1;
                indices.insert(indices.end(), {a, c, b, b, c, d});
            }
        mesh_.vertices = reinterpret_cast<CUdeviceptr>(motion_.vertices);
        mesh_.indices = reinterpret_cast<CUdeviceptr>(scene_.upload(indices));
        mesh_.vertexCount = n * n;
        mesh_.triangleCount = unsigned(indices.size() / 3);
        records_[0] = {motion_.vertices, motion_.normals,
                       reinterpret_cast<const uint3*>(mesh_.indices), vec(0.75f, 0.2f, 0.25f),
                       0.05f};
    }
    void addFloor() {
        Mesh mesh;
        mesh.vertices = {-8, -1.2f, -8, 8, -1.2f, -8, 8, -1.2f, 8, -8, -1.2f, 8};
        mesh.indices = {0, 2, 1, 0, 3, 2};
        const MeshMemory memory = uploadMesh(scene_, mesh);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        floor_ = scene_.build(inputOf(memory, flags));
        records_[1] = {reinterpret_cast<const float3*>(memory.vertices), nullptr,
                       reinterpret_cast<const uint3*>(memory.indices), vec(0.5f), 0.4f};
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<ClothParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    std::unique_ptr<Kernels> kernels_;
    unsigned width_, height_;
    ClothMotion motion_ = {};
    MeshMemory mesh_;
    LiveStructure structure_, world_;
    OptixTraversableHandle floor_ = 0;
    ClothRecord records_[2] = {};
    DeviceBuffer instanceMemory_, image_;
    unsigned frame_ = 0;
};

} // namespace

JobKind clothJob() {
    return secondJob<Cloth>(
        "cloth", "a million triangles moved by a kernel and updated in each frame", 0.002, 0.02);
}

} // namespace bench
