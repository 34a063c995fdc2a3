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
std::string_view gpu_bench_motion_ptx();
std::string_view gpu_bench_moving_instances_ptx();

namespace bench {

uint32_t World::count() const {
    switch (kind) {
    case WorldKind::kInstances:
    case WorldKind::kMovingInstances:
        return uint32_t(matrices.size() / 12);
    case WorldKind::kSpheres:
        return uint32_t(spheres.size() / 4);
    default:
        return mesh.numTriangles();
    }
}

Surfel World::surfel(const Ray& ray, const GpuHit& hit, float time) const {
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
    const auto coordinate = [&](int corner, int k) {
        const size_t i = 3 * size_t(index[corner]) + size_t(k);
        return later.empty() ? mesh.vertices[i]
                             : mesh.vertices[i] * (1 - time) + later[i] * time;
    };
    for (int e = 0; e < 2; ++e)
        for (int k = 0; k < 3; ++k)
            edges[e][k] = coordinate(e + 1, k) - coordinate(0, k);
    float normal[3];
    for (int k = 0; k < 3; ++k)
        normal[k] = edges[0][(k + 1) % 3] * edges[1][(k + 2) % 3] -
                    edges[0][(k + 2) % 3] * edges[1][(k + 1) % 3];
    // Scales are uniform, so that normals turn like vectors.
    const float* m = isOfInstances(kind) ? &matrices[12 * size_t(hit.instance)] : nullptr;
    for (int k = 0; k < 3; ++k)
        s.normal[k] = m ? m[4 * k] * normal[0] + m[4 * k + 1] * normal[1] + m[4 * k + 2] * normal[2]
                        : normal[k];
    return s;
}

const std::vector<std::string>& worldNames() {
    static const std::vector<std::string> names = {
        "terrain 2 M",  "soup 1 M",        "long thin 1 M",      "long thin 1 M, fast trace",
        "spheres 10 M", "100 k instances", "1 M custom spheres", "leaves 1 M, any-hit",
        "moving triangles 1 M", "100 k moving instances"};
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
    case 8:
        world.kind = WorldKind::kMovingTriangles;
        world.mesh = makeScene(SceneKind::kTerrain, some(1e6));
        world.later = movedVertices(world.mesh);
        break;
    case 5:
    case 9:
        world.kind = number == 5 ? WorldKind::kInstances : WorldKind::kMovingInstances;
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
    if (moves(world.kind))
        motion_ = {2, OPTIX_MOTION_FLAG_NONE, 0, 1};
    if (isOfInstances(world.kind))
        describeInstances(context, world);
    else if (world.kind == WorldKind::kSpheres)
        describeSpheres(world);
    else
        describeTriangles(world);
}

void DeviceWorld::describeTriangles(const World& world) {
    vertices_.upload(world.mesh.vertices);
    indices_.upload(world.mesh.indices);
    addresses_[0] = vertices_.address();
    if (!world.later.empty()) {
        later_.upload(world.later);
        addresses_[1] = later_.address();
    }
    input_.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& t = input_.triangleArray;
    t.vertexBuffers = addresses_;
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
    std::vector<OptixTraversableHandle> children(records.size(), childStructure_.handle);
    if (world.kind == WorldKind::kMovingInstances)
        children = makeTransforms(records.size());
    for (size_t i = 0; i < records.size(); ++i) {
        std::memcpy(records[i].transform, &world.matrices[12 * i], sizeof(records[i].transform));
        records[i].instanceId = unsigned(i);
        records[i].visibilityMask = 255;
        records[i].traversableHandle = children[i];
    }
    instances_.upload(records);
    input_.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input_.instanceArray.instances = instances_.address();
    input_.instanceArray.numInstances = world.count();
}

// Alternates between a transform that shifts the child by half its radius and one that also rotates
// it by 30 degrees.
std::vector<OptixTraversableHandle> DeviceWorld::makeTransforms(size_t count) {
    constexpr size_t kStride = (sizeof(OptixSRTMotionTransform) + 63) / 64 * 64;
    std::vector<unsigned char> bytes(count * kStride);
    constexpr float kSine = 0.258819f, kCosine = 0.965926f; // of half the angle
    for (size_t i = 0; i < count; ++i) {
        unsigned char* const to = bytes.data() + i * kStride;
        if (i % 2 == 0) {
            OptixMatrixMotionTransform matrix = {};
            matrix.child = childStructure_.handle;
            matrix.motionOptions = motion_;
            for (int key = 0; key < 2; ++key)
                for (int k = 0; k < 3; ++k)
                    matrix.transform[key][5 * k] = 1;
            matrix.transform[1][3 + 4 * (i / 2 % 3)] = 0.5f;
            std::memcpy(to, &matrix, sizeof(matrix));
        } else {
            OptixSRTMotionTransform srt = {};
            srt.child = childStructure_.handle;
            srt.motionOptions = motion_;
            srt.srtData[0] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0};
            srt.srtData[1] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, kSine, 0, kCosine, 0.5f, 0, 0};
            std::memcpy(to, &srt, sizeof(srt));
        }
    }
    transforms_.upload(bytes);
    std::vector<OptixTraversableHandle> handles(count);
    for (size_t i = 0; i < count; ++i)
        OPTIX_CHECK(optixConvertPointerToTraversableHandle(
            context_, transforms_.address() + i * kStride,
            i % 2 ? OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM
                  : OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM,
            &handles[i]));
    return handles;
}

void DeviceWorld::describeSpheres(const World& world) {
    std::vector<OptixAabb> boxes(world.count());
    for (size_t i = 0; i < boxes.size(); ++i) {
        const float* s = &world.spheres[4 * i];
        // Rounded outwards, so that the sphere stays inside.
        const float r = std::nextafter(s[3], std::numeric_limits<float>::infinity()) * 1.00001f;
        boxes[i] = {s[0] - r, s[1] - r, s[2] - r, s[0] + r, s[1] + r, s[2] + r};
    }
    boxes_.upload(boxes);
    spheres_.upload(world.spheres);
    addresses_[0] = boxes_.address();
    input_.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    OptixBuildInputCustomPrimitiveArray& c = input_.customPrimitiveArray;
    c.aabbBuffers = addresses_;
    c.numPrimitives = world.count();
    c.flags = &flags_;
    c.numSbtRecords = 1;
}

Built DeviceWorld::build(unsigned flags, int repeats) {
    Built built;
    OptixAccelBuildOptions options = {};
    options.buildFlags = flags;
    options.motionOptions = motion_;
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
    options.motionOptions = motion_;
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    Built built = build(options.buildFlags, 1);
    DeviceBuffer temp(built.sizes.tempUpdateSizeInBytes);
    return fastest(repeats, [&] {
        OPTIX_CHECK(optixAccelBuild(context_, nullptr, &options, &input_, 1, temp.address(),
                                    temp.size(), built.memory.address(), built.memory.size(),
                                    &built.handle, nullptr, 0));
    });
}

namespace {

std::string_view ptxFor(WorldKind kind) {
    switch (kind) {
    case WorldKind::kInstances:
        return gpu_bench_instances_ptx();
    case WorldKind::kMovingTriangles:
        return gpu_bench_motion_ptx();
    case WorldKind::kMovingInstances:
        return gpu_bench_moving_instances_ptx();
    default:
        return gpu_bench_ptx();
    }
}

unsigned graphFlagsFor(WorldKind kind) {
    return kind == WorldKind::kMovingInstances ? OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY
           : kind == WorldKind::kInstances
               ? OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING
               : OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
}

} // namespace

Tracer::Tracer(OptixDeviceContext context, WorldKind kind)
    : program_(context, ptxFor(kind), isOfInstances(kind) ? 3 : 2, 2,
               unsigned(kind == WorldKind::kSpheres ? OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM
                                                    : OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE),
               "params", graphFlagsFor(kind), false, moves(kind)) {
    const bool instances = isOfInstances(kind), leaves = kind == WorldKind::kLeaves;
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
    pipeline_ = program_.link(1, instances ? (moves(kind) ? 3 : 2) : 1);
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
    constexpr int kLeast = 5;       // the third launch may wait for the compilation of its pipeline
    cudaEvent_t begin = nullptr, end = nullptr;
    CUDA_CHECK(cudaEventCreate(&begin));
    CUDA_CHECK(cudaEventCreate(&end));
    double best = std::numeric_limits<double>::infinity(), sum = 0;
    for (int i = 0; i < repeats && (i < kLeast || sum < kEnough); ++i) {
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
