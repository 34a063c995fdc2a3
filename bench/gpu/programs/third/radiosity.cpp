// SPDX-License-Identifier: Apache-2.0
// Radiosity: rays between all pairs of patches fill a matrix of form factors, CUDA kernels solve
// for the light, and a picture shows it; device/radiosity.cu.
#include "programs.h"

#include "device/radiosity.h"

std::string_view bench_third_radiosity_ptx();
std::string_view bench_third_radiosity_kernels_ptx();

namespace bench {
namespace {

class Radiosity : public Renderer {
public:
    Radiosity(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings) {
        furnish(std::sqrt(float(settings.some(3200, 120)) / 3200));
        const MeshMemory memory = uploadMesh(scene_, mesh_);
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        RadiosityParams& p = launch_.params;
        p.room = scene_.build(inputOf(memory, flags));
        p.count = unsigned(patches_.size());
        p.patches = scene_.upload(patches_);
        p.factors = scene_.allocate<float>(size_t(p.count) * p.count);
        for (auto*& light : light_)
            light = scene_.allocate<float4>(p.count);
        p.samples = 2;
        p.camera = makeCamera(vec(-3.6f, 2.2f, -4.4f), vec(0.3f, 1.2f, 0.5f), vec(0, 1, 0), 62,
                              settings.aspect());
        p.image = allocatePicture();
    }
    void compile() override {
        programs_.options.numPayloadValues = 2;
        programs_.options.numAttributeValues = 0;
        const OptixModule module = programs_.load(bench_third_radiosity_ptx());
        const auto factors = programs_.raygen({module, "__raygen__formFactors"});
        const auto view = programs_.raygen({module, "__raygen__view"});
        const auto miss = programs_.miss({module, "__miss__none"});
        const auto hit = programs_.hit({{module, "__closesthit__patch"}, {}, {}});
        pipeline_ = programs_.link({factors, view, miss, hit}, {.trace = 8});
        table_.setRaygen(makeRecord(factors));
        viewTable_.setRaygen(makeRecord(view));
        for (Table* table : {&table_, &viewTable_}) {
            table->setMisses(std::vector{makeRecord(miss)});
            table->setHits(std::vector{makeRecord(hit)});
        }
        kernels_ = std::make_unique<Kernels>(bench_third_radiosity_kernels_ptx());
    }
    void renderFrame() override {
        RadiosityParams& p = launch_.params;
        launch_.run(pipeline_, table_, p.count, p.count);
        RadiosityStep step = {p.patches, p.factors, light_[0], light_[1], p.count};
        kernels_->run("emit", p.count, step);
        for (unsigned i = 0; i < 6; ++i) {
            kernels_->run("gather", p.count, step);
            std::swap(step.before, step.after);
        }
        p.light = step.before;
        launch_.run(pipeline_, viewTable_, width_, height_);
    }

private:
    // A rectangle of square patches of about `size`, with the triangles 2 i and 2 i + 1 for patch
    // i.
    void addWall(float3 corner, float3 u, float3 v, float size, float3 albedo,
                 float3 emission = vec(0)) {
        const auto columns = unsigned(std::max(1.0f, std::round(length(u) / size)));
        const auto rows = unsigned(std::max(1.0f, std::round(length(v) / size)));
        const float3 across = u / float(columns), along = v / float(rows);
        for (unsigned i = 0; i < columns * rows; ++i) {
            const float3 a = corner + across * float(i % columns) + along * float(i / columns);
            const uint32_t first = mesh_.numVertices();
            for (const float3 p : {a, a + across, a + across + along, a + along})
                mesh_.vertices.insert(mesh_.vertices.end(), {p.x, p.y, p.z});
            for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u})
                mesh_.indices.push_back(first + k);
            const float3 normal = cross(across, along);
            patches_.push_back(
                {a, across, along, normalize(normal), length(normal), albedo, emission});
        }
    }
    void addBlock(float3 low, float3 size, float patch, float3 albedo) {
        const float3 x = vec(size.x, 0, 0), y = vec(0, size.y, 0), z = vec(0, 0, size.z);
        addWall(low + y, z, x, patch, albedo);
        addWall(low, y, x, patch, albedo);
        addWall(low + z, x, y, patch, albedo);
        addWall(low, z, y, patch, albedo);
        addWall(low + x, y, z, patch, albedo);
    }
    // `detail`: 1 in full size.
    void furnish(float detail) {
        const float size = 0.3f / detail;
        const float3 x = vec(10, 0, 0), y = vec(0, 4, 0), z = vec(0, 0, 10), low = vec(-5, 0, -5);
        const float3 grey = vec(0.75f);
        addWall(low, z, x, size, vec(0.55f, 0.45f, 0.35f));
        addWall(low + y, x, z, size, grey);
        addWall(low + z, y, x, size, vec(0.7f, 0.72f, 0.6f));
        addWall(low, x, y, size, grey);
        addWall(low, y, z, size, vec(0.75f, 0.25f, 0.2f));
        addWall(low + x, z, y, size, vec(0.25f, 0.4f, 0.75f));
        for (const float at : {-2.5f, 2.0f})
            addWall(vec(at, 3.9f, -1), vec(1.6f, 0, 0), vec(0, 0, 1.6f), size, vec(0),
                    vec(14, 13, 11));
        addBlock(vec(-1.5f, 0, 1), vec(1.4f, 2.4f, 1.4f), size, grey);
        addBlock(vec(1.2f, 0, -0.5f), vec(1.8f, 1, 1.2f), size, vec(0.8f, 0.7f, 0.3f));
        addBlock(vec(2.6f, 0, 2.4f), vec(1.2f, 3.1f, 1.2f), size, grey);
        addBlock(vec(-4.4f, 0, -0.5f), vec(1.2f, 0.7f, 3), size, vec(0.35f, 0.6f, 0.4f));
    }

    Mesh mesh_;
    std::vector<Patch> patches_;
    std::unique_ptr<Kernels> kernels_;
    Table viewTable_;
    Launch<RadiosityParams> launch_;
    float4* light_[2] = {};
};

} // namespace

JobKind radiosityJob() {
    return thirdJob<Radiosity>("radiosity",
                               "rays between all pairs of thousands of patches, kernels, a picture",
                               0.002, 0.02);
}

} // namespace bench
