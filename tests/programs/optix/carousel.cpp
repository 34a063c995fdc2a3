// SPDX-License-Identifier: Apache-2.0
// A fair: horses (instances) on carousels (instances of structures of instances) that turn under
// motion transforms, on a platform that a static transform shrinks. Rays of many times look for the
// horses; the host computes where they are.
#include "common.h"

#include <optix_function_table_definition.h>

#include <cmath>
#include <cstring>

#include "device/carousel.h"

namespace {

constexpr unsigned kHorses = 8, kCarousels = 3, kRays = 1500;
constexpr float kPi = 3.14159265f;

struct Graph {
    explicit Graph(OptixDeviceContext context) : context(context) {}

    OptixTraversableHandle instances(const std::vector<OptixInstance>& list, unsigned keys = 1) {
        Buffer buffer(list);
        std::vector<OptixBuildInput> input(1);
        input[0].type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
        input[0].instanceArray = {buffer.ptr(), unsigned(list.size())};
        OptixMotionOptions motion = {};
        motion.numKeys = (unsigned short)keys;
        motion.timeEnd = 1.0f;
        memory.emplace_back();
        return buildAccel(context, input, memory.back(), OPTIX_BUILD_FLAG_PREFER_FAST_TRACE,
                          keys > 1 ? motion : OptixMotionOptions());
    }
    template <class T>
    OptixTraversableHandle transform(const std::vector<char>& bytes, OptixTraversableType type) {
        memory.emplace_back(bytes);
        OptixTraversableHandle handle = 0;
        OPTIX_TRY(
            optixConvertPointerToTraversableHandle(context, memory.back().ptr(), type, &handle));
        return handle;
    }
    OptixDeviceContext context;
    std::vector<Buffer> memory;
};

// A cube of half-width 0.2, outside faces forward.
OptixTraversableHandle cube(Graph& graph) {
    std::vector<float3> corners;
    for (int i = 0; i < 8; ++i)
        corners.push_back({i & 1 ? .2f : -.2f, i & 2 ? .2f : -.2f, i & 4 ? .2f : -.2f});
    const std::vector<uint3> triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                          {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                          {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    Buffer vertices(corners), indices(triangles);
    const CUdeviceptr address = vertices.ptr();
    const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
    std::vector<OptixBuildInput> input(1);
    input[0].type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    auto& array = input[0].triangleArray;
    array.vertexBuffers = &address;
    array.numVertices = 8;
    array.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    array.indexBuffer = indices.ptr();
    array.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    array.numIndexTriplets = unsigned(triangles.size());
    array.flags = &flags;
    array.numSbtRecords = 1;
    graph.memory.emplace_back();
    return buildAccel(graph.context, input, graph.memory.back());
}

OptixInstance place(OptixTraversableHandle handle, unsigned id, float x, float y, float z) {
    OptixInstance instance = {};
    const float matrix[12] = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z};
    std::memcpy(instance.transform, matrix, sizeof matrix);
    instance.instanceId = id;
    instance.visibilityMask = 255;
    instance.traversableHandle = handle;
    return instance;
}

// A quarter turn about z in five keys; quaternions between them are not renormalised by us.
OptixTraversableHandle turning(Graph& graph, OptixTraversableHandle child, float turns) {
    constexpr unsigned kKeys = 5;
    const size_t size = sizeof(OptixSRTMotionTransform) + (kKeys - 2) * sizeof(OptixSRTData);
    std::vector<char> bytes(size);
    OptixSRTMotionTransform head = {};
    head.child = child;
    head.motionOptions.numKeys = kKeys;
    head.motionOptions.timeEnd = 1.0f;
    std::memcpy(bytes.data(), &head, sizeof head);
    for (unsigned k = 0; k < kKeys; ++k) {
        const float angle = 2 * kPi * turns * float(k) / (kKeys - 1);
        OptixSRTData srt = {};
        srt.sx = srt.sy = srt.sz = 1;
        srt.qz = std::sin(angle / 2);
        srt.qw = std::cos(angle / 2);
        std::memcpy(&bytes[offsetof(OptixSRTMotionTransform, srtData) + k * sizeof srt], &srt,
                    sizeof srt);
    }
    return graph.transform<OptixSRTMotionTransform>(bytes,
                                                    OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM);
}

OptixTraversableHandle halved(Graph& graph, OptixTraversableHandle child) {
    OptixStaticTransform transform = {};
    transform.child = child;
    for (int i = 0; i < 3; ++i) {
        transform.transform[5 * i] = 0.5f;
        transform.invTransform[5 * i] = 2.0f;
    }
    std::vector<char> bytes(sizeof transform);
    std::memcpy(bytes.data(), &transform, sizeof transform);
    return graph.transform<OptixStaticTransform>(bytes, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM);
}

OptixTraversableHandle makeFair(Graph& graph) {
    const OptixTraversableHandle horse = cube(graph);
    std::vector<OptixInstance> ring;
    for (unsigned i = 0; i < kHorses; ++i) {
        const float angle = 2 * kPi * float(i) / kHorses;
        ring.push_back(place(horse, 10 + i, std::cos(angle), std::sin(angle), 0));
    }
    const OptixTraversableHandle carousel = graph.instances(ring);
    std::vector<OptixInstance> fair;
    for (unsigned c = 0; c < kCarousels; ++c)
        fair.push_back(place(turning(graph, carousel, 0.25f * float(c)), 100 + c, 3.0f * c, 0, 0));
    return halved(graph, graph.instances(fair, 2));
}

// Aims from above at the place of a horse at the ray's time, a little off its middle.
Ray aim(unsigned i) {
    const unsigned c = i % kCarousels, h = i / kCarousels % kHorses;
    const float time = float(i % 101) / 100.0f;
    const float angle = 2 * kPi * (float(h) / kHorses + 0.25f * c * time);
    Ray ray = {};
    ray.origin = {0.5f * (3.0f * c + std::cos(angle)) + 0.03f, 0.5f * std::sin(angle), 5};
    if (i % 4 == 3)
        ray.origin = {0.5f * 3.0f * c, 0, 5}; // the axis, where nothing is
    ray.direction = {0, 0, -2};
    ray.time = time;
    return ray;
}

bool isRight(unsigned i, const Answer& a) {
    if (i % 4 == 3)
        return a.t == -1.0f;
    const unsigned c = i % kCarousels, h = i / kCarousels % kHorses;
    const Ray ray = aim(i);
    const float z = 5 - 2 * a.t;
    const auto close = [](float x, float y) { return std::fabs(x - y) < 2e-3f; };
    // From the outside: static transform, instance of the fair, motion transform, instance.
    return close(z, 0.1f) && a.id == 10 + h && a.outer == 100 + c && a.depth == 4 &&
           close(a.local.z, 0.2f) && std::fabs(a.local.x) < 0.1f && std::fabs(a.local.y) < 0.1f &&
           close(a.world.x, ray.origin.x) && close(a.world.y, ray.origin.y) && close(a.world.z, z);
}

bool run() {
    OptixDeviceContext context = makeContext();
    auto options = pipelineOptions(2, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY);
    options.usesMotionBlur = true;
    OptixModule module = makeModule(context, options);
    const std::vector<OptixProgramGroup> groups = {
        raygenGroup(context, module, "__raygen__scan"), missGroup(context, module, "__miss__scan"),
        hitGroup(context, module, "__closesthit__scan", nullptr, nullptr)};
    OptixPipeline pipeline = makePipeline(context, options, groups);
    OPTIX_TRY(optixPipelineSetStackSize(pipeline, 0, 0, 4096, 6));
    Graph graph(context);
    const OptixTraversableHandle fair = makeFair(graph);

    Buffer table(std::vector<Record<Nothing>>{
        packed(groups[0], Nothing()), packed(groups[1], Nothing()), packed(groups[2], Nothing())});
    OptixShaderBindingTable sbt = {};
    constexpr unsigned kStride = sizeof(Record<Nothing>);
    sbt.raygenRecord = table.ptr();
    sbt.missRecordBase = table.ptr() + kStride;
    sbt.hitgroupRecordBase = table.ptr() + 2 * kStride;
    sbt.missRecordStrideInBytes = sbt.hitgroupRecordStrideInBytes = kStride;
    sbt.missRecordCount = sbt.hitgroupRecordCount = 1;

    std::vector<Ray> rays;
    for (unsigned i = 0; i < kRays; ++i)
        rays.push_back(aim(i));
    Buffer rayBuffer(rays), answers(kRays * sizeof(Answer));
    Params params = {fair, rayBuffer.as<Ray>(), answers.as<Answer>(), {{1, kRays}, {1, kRays}}};
    Buffer paramBuffer(std::vector<Params>{params});
    OPTIX_TRY(optixLaunch(pipeline, nullptr, paramBuffer.ptr(), sizeof params, &sbt, kRays, 1, 1));
    const auto seen = answers.download<Answer>();
    unsigned wrong = 0;
    for (unsigned i = 0; i < kRays; ++i) {
        if (isRight(i, seen[i]))
            continue;
        if (wrong++ == 0)
            std::printf("ray %u: t %f id %u outer %u depth %u local %f %f %f world %f %f %f\n", i,
                        seen[i].t, seen[i].id, seen[i].outer, seen[i].depth, seen[i].local.x,
                        seen[i].local.y, seen[i].local.z, seen[i].world.x, seen[i].world.y,
                        seen[i].world.z);
    }
    std::printf("%u of %u rays wrong\n", wrong, kRays);
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return wrong == 0;
}

} // namespace

int main() {
    return runChecked(run);
}
