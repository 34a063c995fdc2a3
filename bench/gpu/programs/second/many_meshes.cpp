// SPDX-License-Identifier: Apache-2.0
// Five thousand meshes in 20,000 instances, with four records for each mesh; device/many_meshes.cu.
#include "programs.h"

#include "device/many_meshes.h"

#include <cmath>

std::string_view bench_second_many_meshes_ptx();

namespace bench {
namespace {

constexpr unsigned kShapes = 24, kTexturesOfCity = 64, kSurfaces = 3;

// All meshes in two arrays; each has two materials.
struct Blocks {
    std::vector<float> vertices;
    std::vector<uint32_t> indices;
    std::vector<uint8_t> materials;
    struct Range {
        size_t vertex, triangle;
        unsigned vertices, triangles;
    };
    std::vector<Range> ranges;

    void add(const Mesh& mesh, float3 scale) {
        ranges.push_back(
            {vertices.size() / 3, indices.size() / 3, mesh.numVertices(), mesh.numTriangles()});
        const float s[3] = {scale.x, scale.y, scale.z};
        for (size_t i = 0; i < mesh.vertices.size(); ++i)
            vertices.push_back(mesh.vertices[i] * s[i % 3]);
        indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
        for (unsigned i = 0; i < mesh.numTriangles(); ++i)
            materials.push_back(i < mesh.numTriangles() / 2 ? 0 : 1);
    }
};

Blocks makeBlocks(unsigned count) {
    std::vector<Mesh> shapes;
    for (unsigned i = 0; i < kShapes; ++i)
        shapes.push_back(makeRock(80 + 60 * i));
    Blocks blocks;
    Mesh ground = makeScene(SceneKind::kTerrain, 20000);
    blocks.add(ground, vec(1.2f, 0.2f, 1.2f));
    for (unsigned i = 1; i < count; ++i)
        blocks.add(shapes[i % kShapes], vec(0.6f + 0.8f * randomOf(i, 1), 0.8f + randomOf(i, 2),
                                            0.6f + 0.8f * randomOf(i, 3)));
    return blocks;
}

class ManyMeshes : public Application {
public:
    ManyMeshes(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), width_(settings.width), height_(settings.height) {
        const Blocks blocks = makeBlocks(settings.some(5000, 30));
        vertices_ = scene_.upload(blocks.vertices);
        indices_ = scene_.upload(blocks.indices);
        materials_ = scene_.upload(blocks.materials);
        buildMeshes(blocks);
        for (unsigned i = 0; i < kTexturesOfCity; ++i)
            textures_.emplace_back(spots(512 * i, 64), 64);
        addRecords(blocks);
        CityParams& p = launch_.params;
        p.world = scene_.buildInstances(placeMeshes(settings.some(20000, 100)));
        p.camera =
            makeCamera(vec(-52, 26, -56), vec(0, 6, -6), vec(0, 1, 0), 48, settings.aspect());
        p.sun = normalize(vec(-0.4f, 0.7f, -0.5f));
        p.samples = 1;
        p.maxDepth = 3;
        image_.allocate(sizeof(float4) * width_ * height_);
        p.image = image_.as<float4>();
    }
    void compile() override {
        const unsigned out =
            OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ | OPTIX_PAYLOAD_SEMANTICS_CH_WRITE;
        std::vector<unsigned> words(14, out);
        words[12] = out | OPTIX_PAYLOAD_SEMANTICS_MS_WRITE;
        words[13] =
            OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE | OPTIX_PAYLOAD_SEMANTICS_CH_READ_WRITE;
        const unsigned flag =
            OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE | OPTIX_PAYLOAD_SEMANTICS_MS_WRITE;
        OptixPayloadType types[2] = {{14, words.data()}, {1, &flag}};
        programs_.moduleOptions.numPayloadTypes = 2;
        programs_.moduleOptions.payloadTypes = types;
        programs_.options.numPayloadValues = 0;
        programs_.options.traversableGraphFlags =
            OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        const OptixModule module = programs_.load(bench_second_many_meshes_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__city"});
        const auto pathMiss = programs_.miss({module, "__miss__path"});
        const auto shadowMiss = programs_.miss({module, "__miss__shadow"});
        std::vector<OptixProgramGroup> groups = {raygen, pathMiss, shadowMiss};
        for (const char* name :
             {"__closesthit__matt", "__closesthit__glossy", "__closesthit__coated"})
            groups.push_back(programs_.hit({{module, name}, {}, {}}));
        groups.push_back(programs_.hit({}, &types[1])); // of shadow rays
        pipeline_ = programs_.link(groups, {.trace = 1, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(pathMiss), makeRecord(shadowMiss)});
        std::vector<SbtRecord<CityRecord>> records;
        for (size_t i = 0; i < records_.size(); ++i) {
            records.push_back(makeRecord(groups[3 + i % kSurfaces], records_[i]));
            records.push_back(makeRecord(groups[3 + kSurfaces], records_[i]));
        }
        table_.setHits(records);
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    OptixBuildInput inputOfMesh(const Blocks::Range& r, const CUdeviceptr& vertices,
                                const unsigned (&flags)[2]) const {
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        OptixBuildInputTriangleArray& t = input.triangleArray;
        t.vertexBuffers = &vertices;
        t.numVertices = r.vertices;
        t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        t.vertexStrideInBytes = 3 * sizeof(float);
        t.indexBuffer = reinterpret_cast<CUdeviceptr>(indices_ + 3 * r.triangle);
        t.numIndexTriplets = r.triangles;
        t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
        t.flags = flags;
        t.numSbtRecords = 2;
        t.sbtIndexOffsetBuffer = reinterpret_cast<CUdeviceptr>(materials_ + r.triangle);
        t.sbtIndexOffsetSizeInBytes = sizeof(uint8_t);
        return input;
    }
    // One block of memory for all structures, and no waiting between builds.
    void buildMeshes(const Blocks& blocks) {
        OptixAccelBuildOptions options = {};
        options.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
        options.operation = OPTIX_BUILD_OPERATION_BUILD;
        const unsigned flags[2] = {OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT,
                                   OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT};
        std::vector<size_t> offsets = {0};
        size_t largest = 0;
        for (const Blocks::Range& r : blocks.ranges) {
            const auto vertices = reinterpret_cast<CUdeviceptr>(vertices_ + 3 * r.vertex);
            const OptixBuildInput input = inputOfMesh(r, vertices, flags);
            OptixAccelBufferSizes sizes = {};
            OPTIX_CHECK(
                optixAccelComputeMemoryUsage(scene_.context(), &options, &input, 1, &sizes));
            offsets.push_back(offsets.back() + (sizes.outputSizeInBytes + 127) / 128 * 128);
            largest = std::max(largest, sizes.tempSizeInBytes);
        }
        structures_.allocate(offsets.back());
        const DeviceBuffer temporary(largest);
        for (size_t i = 0; i < blocks.ranges.size(); ++i) {
            const auto vertices =
                reinterpret_cast<CUdeviceptr>(vertices_ + 3 * blocks.ranges[i].vertex);
            const OptixBuildInput input = inputOfMesh(blocks.ranges[i], vertices, flags);
            handles_.emplace_back();
            OPTIX_CHECK(optixAccelBuild(scene_.context(), nullptr, &options, &input, 1,
                                        temporary.address(), temporary.size(),
                                        structures_.address() + offsets[i],
                                        offsets[i + 1] - offsets[i], &handles_.back(), nullptr, 0));
        }
        CUDA_CHECK(cudaDeviceSynchronize());
    }
    void addRecords(const Blocks& blocks) {
        for (unsigned i = 0; i < 2 * blocks.ranges.size(); ++i) {
            const Blocks::Range& r = blocks.ranges[i / 2];
            CityRecord record = {};
            record.vertices = reinterpret_cast<const float3*>(vertices_ + 3 * r.vertex);
            record.indices = reinterpret_cast<const uint3*>(indices_ + 3 * r.triangle);
            record.albedo = textures_[(i * 7 + i / 9) % kTexturesOfCity].object();
            record.color = colorOf(i) * 1.3f;
            record.roughness = 0.05f + 0.4f * randomOf(i, 6);
            record.scale = i < 2 ? 0.05f : 0.5f + randomOf(i, 7);
            records_.push_back(record);
        }
    }
    std::vector<OptixInstance> placeMeshes(unsigned count) const {
        std::vector<OptixInstance> instances = {instanceOf(handles_[0], kIdentity)};
        const auto across = unsigned(std::ceil(std::sqrt(float(count))));
        const float step = 104.0f / float(across);
        for (unsigned i = 0; i < count; ++i) {
            const unsigned mesh = 1 + i % unsigned(handles_.size() - 1);
            const float s = step * (0.3f + 0.25f * randomOf(i, 1));
            const float x = (float(i % across) + 0.8f * randomOf(i, 2)) * step - 52;
            const float z = (float(i / across) + 0.8f * randomOf(i, 3)) * step - 52;
            const float m[12] = {s, 0, 0, x, 0, s * 1.5f, 0, 2 + 3 * randomOf(i, 4), 0, 0, s, z};
            instances.push_back(instanceOf(handles_[mesh], m, i, 4 * mesh));
        }
        return instances;
    }

    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<CityParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    unsigned width_, height_;
    const float* vertices_ = nullptr;
    const uint32_t* indices_ = nullptr;
    const uint8_t* materials_ = nullptr;
    std::vector<OptixTraversableHandle> handles_;
    std::vector<CityRecord> records_; // two for each mesh
    std::vector<Texture> textures_;
    DeviceBuffer structures_, image_;
};

} // namespace

JobKind manyMeshesJob() {
    return secondJob<ManyMeshes>("many_meshes",
                                 "5,000 meshes in 20,000 instances, 20,000 records; payload types",
                                 0.01, 0.1);
}

} // namespace bench
