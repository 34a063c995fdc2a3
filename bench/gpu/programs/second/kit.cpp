// SPDX-License-Identifier: Apache-2.0
#include "kit.h"

#include <optix_stack_size.h>

#include <chrono>
#include <cstring>

namespace bench {

namespace {

// Adds the time of its life in milliseconds.
class Stopwatch {
public:
    explicit Stopwatch(double& total) : total_(total) {}
    ~Stopwatch() {
        total_ +=
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
                .count();
    }

private:
    double& total_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace

Programs::Programs(OptixDeviceContext context) : context_(context) {
    moduleOptions.optLevel = OPTIX_COMPILE_OPTIMIZATION_DEFAULT;
    moduleOptions.debugLevel = OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL;
    options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
    options.numPayloadValues = 2;
    options.numAttributeValues = 2;
    options.pipelineLaunchParamsVariableName = "params";
    options.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);
}

Programs::~Programs() {
    for (OptixPipeline pipeline : pipelines_)
        optixPipelineDestroy(pipeline);
    for (OptixProgramGroup group : groups_)
        optixProgramGroupDestroy(group);
    for (OptixModule module : modules_)
        optixModuleDestroy(module);
}

OptixModule Programs::load(std::string_view ptx) {
    const Stopwatch watch(compileTime_);
    OptixModule module = nullptr;
    OPTIX_CHECK(optixModuleCreateFromPTX(context_, &moduleOptions, &options, ptx.data(), ptx.size(),
                                         nullptr, nullptr, &module));
    modules_.push_back(module);
    return module;
}

OptixModule Programs::builtin(OptixPrimitiveType type, unsigned buildFlags) {
    const Stopwatch watch(compileTime_);
    OptixBuiltinISOptions builtin = {};
    builtin.builtinISModuleType = type;
    builtin.usesMotionBlur = 0; // no program of these sets moves vertices
    builtin.buildFlags = buildFlags;
    OptixModule module = nullptr;
    OPTIX_CHECK(optixBuiltinISModuleGet(context_, &moduleOptions, &options, &builtin, &module));
    modules_.push_back(module);
    return module;
}

OptixProgramGroup Programs::add(const OptixProgramGroupDesc& description, OptixPayloadType* type) {
    const Stopwatch watch(compileTime_);
    OptixProgramGroupOptions groupOptions = {};
    groupOptions.payloadType = type;
    OptixProgramGroup group = nullptr;
    OPTIX_CHECK(optixProgramGroupCreate(context_, &description, 1, &groupOptions, nullptr, nullptr,
                                        &group));
    groups_.push_back(group);
    return group;
}

OptixProgramGroup Programs::raygen(Function function) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    description.raygen = {function.module, function.name};
    return add(description, nullptr);
}

OptixProgramGroup Programs::miss(Function function, OptixPayloadType* type) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
    description.miss = {function.module, function.name};
    return add(description, type);
}

OptixProgramGroup Programs::hit(const HitFunctions& f, OptixPayloadType* type) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
    description.hitgroup = {f.closestHit.module, f.closestHit.name,     f.anyHit.module,
                            f.anyHit.name,       f.intersection.module, f.intersection.name};
    return add(description, type);
}

OptixProgramGroup Programs::direct(Function function) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
    description.callables.moduleDC = function.module;
    description.callables.entryFunctionNameDC = function.name;
    return add(description, nullptr);
}

OptixProgramGroup Programs::continuation(Function function) {
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
    description.callables.moduleCC = function.module;
    description.callables.entryFunctionNameCC = function.name;
    return add(description, nullptr);
}

OptixPipeline Programs::link(const std::vector<OptixProgramGroup>& groups, const Depths& depths) {
    const Stopwatch watch(compileTime_);
    OptixPipelineLinkOptions linkOptions = {};
    linkOptions.maxTraceDepth = depths.trace;
    linkOptions.debugLevel = moduleOptions.debugLevel;
    OptixPipeline pipeline = nullptr;
    OPTIX_CHECK(optixPipelineCreate(context_, &options, &linkOptions, groups.data(),
                                    unsigned(groups.size()), nullptr, nullptr, &pipeline));
    pipelines_.push_back(pipeline);
    OptixStackSizes sizes = {};
    for (OptixProgramGroup group : groups)
        OPTIX_CHECK(optixUtilAccumulateStackSizes(group, &sizes));
    unsigned fromTraversal = 0, fromState = 0, stack = 0;
    OPTIX_CHECK(optixUtilComputeStackSizes(&sizes, depths.trace, depths.continuationCallables,
                                           depths.directCallables, &fromTraversal, &fromState,
                                           &stack));
    OPTIX_CHECK(optixPipelineSetStackSize(pipeline, fromTraversal, fromState, stack, depths.graph));
    return pipeline;
}

OptixTraversableHandle Scene::build(const OptixBuildInput& input, unsigned flags) {
    structures_.push_back(buildAccel(context_, input, {}, flags));
    return structures_.back().handle;
}

OptixTraversableHandle Scene::buildBoxes(const std::vector<OptixAabb>& boxes, unsigned flags) {
    DeviceBuffer memory;
    memory.upload(boxes);
    const CUdeviceptr address = memory.address();
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    input.customPrimitiveArray.aabbBuffers = &address;
    input.customPrimitiveArray.numPrimitives = unsigned(boxes.size());
    input.customPrimitiveArray.flags = &flags;
    input.customPrimitiveArray.numSbtRecords = 1;
    return build(input);
}

OptixTraversableHandle Scene::buildInstances(const std::vector<OptixInstance>& instances) {
    structures_.push_back(::buildInstances(context_, instances));
    return structures_.back().handle;
}

void LiveStructure::build(const OptixBuildInput& input, OptixBuildOperation operation) {
    OptixAccelBuildOptions options = {};
    options.buildFlags = flags_;
    options.operation = operation;
    if (output_.size() == 0) {
        OptixAccelBufferSizes sizes = {};
        OPTIX_CHECK(optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes));
        output_.allocate(sizes.outputSizeInBytes);
        temporary_.allocate(std::max(sizes.tempSizeInBytes, sizes.tempUpdateSizeInBytes));
    }
    OPTIX_CHECK(optixAccelBuild(context_, nullptr, &options, &input, 1, temporary_.address(),
                                temporary_.size(), output_.address(), output_.size(), &handle_,
                                nullptr, 0));
}

MeshMemory uploadMesh(Scene& scene, const Mesh& mesh) {
    MeshMemory m;
    m.vertices = reinterpret_cast<CUdeviceptr>(scene.upload(mesh.vertices));
    m.indices = reinterpret_cast<CUdeviceptr>(scene.upload(mesh.indices));
    m.vertexCount = mesh.numVertices();
    m.triangleCount = mesh.numTriangles();
    return m;
}

OptixBuildInput inputOf(const MeshMemory& mesh, const unsigned& flags) {
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& t = input.triangleArray;
    t.vertexBuffers = &mesh.vertices;
    t.numVertices = mesh.vertexCount;
    t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    t.indexBuffer = mesh.indices;
    t.numIndexTriplets = mesh.triangleCount;
    t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    t.flags = &flags;
    t.numSbtRecords = 1;
    return input;
}

OptixTraversableHandle buildMaterials(Scene& scene, const MaterialMesh& mesh, MeshMemory& memory) {
    memory = {reinterpret_cast<CUdeviceptr>(scene.upload(mesh.vertices)),
              reinterpret_cast<CUdeviceptr>(scene.upload(mesh.indices)),
              unsigned(mesh.vertices.size() / 3), unsigned(mesh.indices.size() / 3)};
    const std::vector<unsigned> flags(mesh.looks.size(), OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
    OptixBuildInput input = inputOf(memory, flags[0]);
    OptixBuildInputTriangleArray& t = input.triangleArray;
    t.flags = flags.data();
    t.numSbtRecords = unsigned(flags.size());
    t.sbtIndexOffsetBuffer = reinterpret_cast<CUdeviceptr>(scene.upload(mesh.materials));
    t.sbtIndexOffsetSizeInBytes = sizeof(uint8_t);
    return scene.build(input);
}

const float kIdentity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

OptixInstance instanceOf(OptixTraversableHandle child, const float* transform, unsigned id,
                         unsigned record) {
    OptixInstance instance = {};
    std::memcpy(instance.transform, transform, sizeof(instance.transform));
    instance.instanceId = id;
    instance.sbtOffset = record;
    instance.visibilityMask = 255;
    instance.traversableHandle = child;
    return instance;
}

OptixBuildInput inputOfInstances(CUdeviceptr instances, size_t count) {
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input.instanceArray.instances = instances;
    input.instanceArray.numInstances = unsigned(count);
    return input;
}

Camera cameraOf(const Mesh& m, const JobSettings& settings) {
    return makeCamera(vec(m.eye[0], m.eye[1], m.eye[2]), vec(m.target[0], m.target[1], m.target[2]),
                      vec(0, 1, 0), m.fovDegrees, settings.aspect());
}

float3 vertexOf(const Mesh& mesh, size_t triangle, unsigned corner) {
    const float* const v = &mesh.vertices[3 * size_t(mesh.indices[3 * triangle + corner])];
    return vec(v[0], v[1], v[2]);
}

} // namespace bench
