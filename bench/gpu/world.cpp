// SPDX-License-Identifier: Apache-2.0
#include "world.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

// The PTX of programs.cu, built into this program.
std::string_view gpu_bench_ptx();
std::string_view gpu_bench_instances_ptx();

namespace bench {

uint32_t World::count() const {
    switch (kind) {
    case WorldKind::kInstances:
        return uint32_t(matrices.size() / 12);
    case WorldKind::kSpheres:
        return uint32_t(spheres.size() / 4);
    default:
        return mesh.numTriangles();
    }
}

Surfel World::surfel(const Ray& ray, const GpuHit& hit) const {
    Surfel s = {hit.primitive != ~0u, hit.t, {}};
    if (!s.hit)
        return s;
    if (kind == WorldKind::kSpheres) {
        for (int k = 0; k < 3; ++k)
            s.normal[k] = ray.origin[k] + ray.direction[k] * hit.t -
                          spheres[4 * size_t(hit.primitive) + size_t(k)];
        return s;
    }
    float edges[2][3];
    const uint32_t* index = &mesh.indices[3 * size_t(hit.primitive)];
    for (int e = 0; e < 2; ++e)
        for (int k = 0; k < 3; ++k)
            edges[e][k] = mesh.vertices[3 * size_t(index[e + 1]) + size_t(k)] -
                          mesh.vertices[3 * size_t(index[0]) + size_t(k)];
    float normal[3];
    for (int k = 0; k < 3; ++k)
        normal[k] = edges[0][(k + 1) % 3] * edges[1][(k + 2) % 3] -
                    edges[0][(k + 2) % 3] * edges[1][(k + 1) % 3];
    // Scales are uniform, so that normals turn like vectors.
    const float* m = kind == WorldKind::kInstances ? &matrices[12 * size_t(hit.instance)] : nullptr;
    for (int k = 0; k < 3; ++k)
        s.normal[k] = m ? m[4 * k] * normal[0] + m[4 * k + 1] * normal[1] + m[4 * k + 2] * normal[2]
                        : normal[k];
    return s;
}

const std::vector<std::string>& worldNames() {
    static const std::vector<std::string> names = {
        "terrain 2 M",  "soup 1 M",        "long thin 1 M",      "long thin 1 M, fast trace",
        "spheres 10 M", "100 k instances", "1 M custom spheres", "leaves 1 M, any-hit"};
    return names;
}

World makeWorld(const std::string& name, double scale) {
    const auto some = [&](double count) { return uint32_t(std::max(16.0, count * scale)); };
    World world;
    world.name = name;
    const auto& names = worldNames();
    const auto number = std::find(names.begin(), names.end(), name) - names.begin();
    switch (number) {
    case 0:
        world.mesh = makeScene(SceneKind::kTerrain, some(2e6));
        break;
    case 1:
        world.mesh = makeScene(SceneKind::kSoup, some(1e6));
        break;
    case 2:
    case 3:
        world.mesh = makeScene(SceneKind::kLongThin, some(1e6));
        world.buildFlags = number == 3 ? OPTIX_BUILD_FLAG_PREFER_FAST_TRACE : 0;
        break;
    case 4:
        world.mesh = makeScene(SceneKind::kSpheres, some(1e7));
        break;
    case 5:
        world.kind = WorldKind::kInstances;
        world.mesh = makeRock(4000);
        world.matrices = scatter(some(1e5));
        break;
    case 6:
        world.kind = WorldKind::kSpheres;
        world.spheres = makeBalls(some(1e6), world.mesh);
        break;
    case 7:
        world.kind = WorldKind::kLeaves;
        world.mesh = makeLeaves(some(1e6));
        break;
    default:
        throw std::runtime_error("there is no scene '" + name + "'");
    }
    return world;
}

DeviceWorld::DeviceWorld(OptixDeviceContext context, const World& world) : context_(context) {
    if (world.kind == WorldKind::kInstances)
        describeInstances(context, world);
    else if (world.kind == WorldKind::kSpheres)
        describeSpheres(world);
    else
        describeTriangles(world);
}

void DeviceWorld::describeTriangles(const World& world) {
    vertices_.upload(world.mesh.vertices);
    indices_.upload(world.mesh.indices);
    address_ = vertices_.address();
    input_.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& t = input_.triangleArray;
    t.vertexBuffers = &address_;
    t.numVertices = world.mesh.numVertices();
    t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    t.indexBuffer = indices_.address();
    t.numIndexTriplets = world.mesh.numTriangles();
    t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    t.flags = &flags_;
    t.numSbtRecords = 1;
}

void DeviceWorld::describeInstances(OptixDeviceContext context, const World& world) {
    World rock;
    rock.mesh = world.mesh;
    child_ = std::make_unique<DeviceWorld>(context, rock);
    childStructure_ = child_->build(OPTIX_BUILD_FLAG_ALLOW_COMPACTION, 1);
    std::vector<OptixInstance> records(world.count());
    for (size_t i = 0; i < records.size(); ++i) {
        std::memcpy(records[i].transform, &world.matrices[12 * i], sizeof(records[i].transform));
        records[i].instanceId = unsigned(i);
        records[i].visibilityMask = 255;
        records[i].traversableHandle = childStructure_.handle;
    }
    instances_.upload(records);
    input_.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input_.instanceArray.instances = instances_.address();
    input_.instanceArray.numInstances = world.count();
}

void DeviceWorld::describeSpheres(const World& world) {
    std::vector<OptixAabb> boxes(world.count());
    for (size_t i = 0; i < boxes.size(); ++i) {
        const float* s = &world.spheres[4 * i];
        // Outwards, so that rounding leaves the sphere inside.
        const float r = std::nextafter(s[3], std::numeric_limits<float>::infinity()) * 1.00001f;
        boxes[i] = {s[0] - r, s[1] - r, s[2] - r, s[0] + r, s[1] + r, s[2] + r};
    }
    boxes_.upload(boxes);
    spheres_.upload(world.spheres);
    address_ = boxes_.address();
    input_.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    OptixBuildInputCustomPrimitiveArray& c = input_.customPrimitiveArray;
    c.aabbBuffers = &address_;
    c.numPrimitives = world.count();
    c.flags = &flags_;
    c.numSbtRecords = 1;
}

Built DeviceWorld::build(unsigned flags, int repeats) {
    Built built;
    OptixAccelBuildOptions options = {};
    options.buildFlags = flags;
    options.operation = OPTIX_BUILD_OPERATION_BUILD;
    OPTIX_CHECK(optixAccelComputeMemoryUsage(context_, &options, &input_, 1, &built.sizes));
    DeviceBuffer temp(built.sizes.tempSizeInBytes), size(sizeof(uint64_t));
    built.memory.allocate(built.sizes.outputSizeInBytes);
    const bool compacts = flags & OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
    OptixAccelEmitDesc emit = {size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
    built.milliseconds = fastest(repeats, [&] {
        OPTIX_CHECK(optixAccelBuild(context_, nullptr, &options, &input_, 1, temp.address(),
                                    temp.size(), built.memory.address(), built.memory.size(),
                                    &built.handle, compacts ? &emit : nullptr, compacts));
    });
    if (!compacts)
        return built;
    built.compactedSize = size.download<uint64_t>()[0];
    DeviceBuffer compacted(built.compactedSize);
    OPTIX_CHECK(optixAccelCompact(context_, nullptr, built.handle, compacted.address(),
                                  compacted.size(), &built.handle));
    CUDA_CHECK(cudaDeviceSynchronize());
    built.memory = std::move(compacted);
    return built;
}

double DeviceWorld::update(unsigned flags, int repeats) {
    OptixAccelBuildOptions options = {};
    options.buildFlags = flags | OPTIX_BUILD_FLAG_ALLOW_UPDATE;
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    Built built = build(options.buildFlags, 1);
    DeviceBuffer temp(built.sizes.tempUpdateSizeInBytes);
    return fastest(repeats, [&] {
        OPTIX_CHECK(optixAccelBuild(context_, nullptr, &options, &input_, 1, temp.address(),
                                    temp.size(), built.memory.address(), built.memory.size(),
                                    &built.handle, nullptr, 0));
    });
}

Tracer::Tracer(OptixDeviceContext context, WorldKind kind)
    : program_(context, kind == WorldKind::kInstances ? gpu_bench_instances_ptx() : gpu_bench_ptx(),
               kind == WorldKind::kInstances ? 3 : 2, 2,
               unsigned(kind == WorldKind::kSpheres ? OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM
                                                    : OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE),
               "params",
               kind == WorldKind::kInstances
                   ? OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING
                   : OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS) {
    const bool instances = kind == WorldKind::kInstances, leaves = kind == WorldKind::kLeaves;
    const SbtRecord<NoData> records[] = {
        makeRecord(program_.addRaygen(instances ? "__raygen__closest_instance"
                                      : leaves  ? "__raygen__closest_cutout"
                                                : "__raygen__closest")),
        makeRecord(program_.addRaygen(leaves ? "__raygen__any_cutout" : "__raygen__any")),
        makeRecord(program_.addMiss("__miss__clear")),
        makeRecord(program_.addHitgroup(
            instances ? "__closesthit__store_instance" : "__closesthit__store",
            leaves ? "__anyhit__cutout" : nullptr,
            kind == WorldKind::kSpheres ? "__intersection__sphere" : nullptr))};
    pipeline_ = program_.link(1, instances ? 2 : 1);
    records_.upload(records, sizeof(records));
    params_.allocate(sizeof(GpuRaysParams));
    constexpr unsigned kStride = sizeof(records[0]);
    table_.missRecordBase = records_.address() + 2 * kStride;
    table_.missRecordStrideInBytes = kStride;
    table_.missRecordCount = 1;
    table_.hitgroupRecordBase = records_.address() + 3 * kStride;
    table_.hitgroupRecordStrideInBytes = kStride;
    table_.hitgroupRecordCount = 1;
}

void Tracer::prepare(const GpuRaysParams& params) {
    CUDA_CHECK(cudaMemcpy(params_.data(), &params, sizeof(params), cudaMemcpyHostToDevice));
}

void Tracer::queue(RayQuery query, size_t count) {
    table_.raygenRecord = records_.address() + size_t(query) * sizeof(SbtRecord<NoData>);
    OPTIX_CHECK(optixLaunch(pipeline_, nullptr, params_.address(), sizeof(GpuRaysParams), &table_,
                            unsigned(count), 1, 1));
}

double fastest(int repeats, const std::function<void()>& work) {
    constexpr double kEnough = 500; // milliseconds
    cudaEvent_t begin = nullptr, end = nullptr;
    CUDA_CHECK(cudaEventCreate(&begin));
    CUDA_CHECK(cudaEventCreate(&end));
    double best = std::numeric_limits<double>::infinity(), sum = 0;
    for (int i = 0; i < repeats && (i < 2 || sum < kEnough); ++i) {
        CUDA_CHECK(cudaEventRecord(begin, nullptr));
        work();
        CUDA_CHECK(cudaEventRecord(end, nullptr));
        CUDA_CHECK(cudaEventSynchronize(end));
        float ms = 0;
        CUDA_CHECK(cudaEventElapsedTime(&ms, begin, end));
        best = std::min(best, double(ms));
        sum += ms;
    }
    CUDA_CHECK(cudaEventDestroy(begin));
    CUDA_CHECK(cudaEventDestroy(end));
    return best;
}

} // namespace bench
